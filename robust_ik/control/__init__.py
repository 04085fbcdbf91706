"""Control: from tasks and limits to joint velocities, by bounds, resolvers, a controller and a compiled stepper."""
