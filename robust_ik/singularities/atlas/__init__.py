"""All families of an arm: the search, its state, the table and its file."""
