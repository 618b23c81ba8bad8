"""Training of the embedded model, from pictures that `w2c scenes render` makes."""
