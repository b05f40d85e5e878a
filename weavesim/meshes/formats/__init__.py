"""One reader per format: from a ``Source`` to a ``MeshFile``, with every cell of the file accounted for."""
