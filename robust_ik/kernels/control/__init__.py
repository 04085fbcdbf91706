"""One step of a velocity controller in compiled code: levels of tasks within bounds."""
