"""Self-contained HTML pages with scenes, tables and charts."""
