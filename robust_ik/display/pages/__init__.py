"""Self-contained HTML pages around scenes, tables and charts."""
