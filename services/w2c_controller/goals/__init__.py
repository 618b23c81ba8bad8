"""What is asked of the controller, and what is refused before anything moves."""
