"""Points within bounds, in compiled code: plain numbers, which know nothing of levels or of a desk."""
