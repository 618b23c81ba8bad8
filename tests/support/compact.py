"""JSON without a character that says nothing."""

import re

JSON_STRING = re.compile(r'"(?:[^"\\]|\\.)*"')


def is_compact(text: str) -> bool:
    """Return whether JSON has no white space outside its strings.

    It is not compared with `json.dumps`: a number may have more digits than a float.
    """
    return not re.search(r"\s", JSON_STRING.sub("", text))
