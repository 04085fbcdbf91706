"""URDF and xacro files: read, repaired and checked."""
