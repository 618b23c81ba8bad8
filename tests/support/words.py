"""What strangers may type."""

from hypothesis import strategies as st

MARKS = ("<|pad|>", "<|end|>", "<|system|>", "<|user|>", "<|assistant|>")


def words_without_marks() -> st.SearchStrategy[str]:
    """Return any text but the control tokens of the embedded model, which are refused."""
    return st.text(max_size=40).filter(lambda text: not any(mark in text for mark in MARKS))
