"""From tasks and limits to joint velocities: problems, bounds, resolvers, the controller, the stepper."""
