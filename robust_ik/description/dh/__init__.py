"""DH tables, from TOML files and to URDF."""
