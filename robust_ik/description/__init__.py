"""What a robot is before it moves: joints, links, limits and shapes, from URDF files and DH tables. No Pinocchio."""
