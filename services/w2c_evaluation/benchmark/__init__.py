"""The benchmark of the paper: pictures, prompts and masks (`w2c benchmark make|check`)."""
