"""One service's code, run on its recorded inputs: does it answer as it did?"""
