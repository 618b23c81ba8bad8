"""The two quadratic programs of SEIKO, one layout a contact set, and the states they move."""
