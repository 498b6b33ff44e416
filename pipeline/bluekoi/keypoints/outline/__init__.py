"""The silhouette detector's parts: background, search, template, edges, tail, tracking."""
