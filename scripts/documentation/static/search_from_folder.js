// A browser lets no page read another one from a folder: results are shown without excerpts there, and without an error.
if (window.location.protocol === "file:") {
  DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
}
