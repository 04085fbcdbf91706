"""The robot: a Pinocchio model with its joints, frames and kinematics. The only place of Pinocchio."""
