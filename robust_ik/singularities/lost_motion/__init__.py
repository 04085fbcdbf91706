"""What is lost at a singular configuration: twists, wrenches, words, and whether it can be left."""
