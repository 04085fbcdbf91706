"""Robot descriptions: joints, links, limits and shapes, read from URDF files and DH tables. No Pinocchio."""
