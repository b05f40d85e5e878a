"""Contact of edges with edges at creases of a sheet that touches itself: tables, state, launches."""
