"""May this place be touched at all? What the veto list says, and where it could not be asked."""

from dataclasses import dataclass
from typing import Literal

from w2c_dialogue.advice.heat import Hit

UncheckedVeto = Literal["refuse", "allow"]


@dataclass(frozen=True)
class Verdict:
    """What the veto list says about one target."""

    hits: tuple[Hit, ...] = ()
    """No-go phrases that the picture shows there"""
    named: str = ""
    """The no-go phrase that the operator's own words name as the place"""
    unknown: tuple[str, ...] = ()
    """No-go phrases that the vision model does not know: they were not looked for"""
    failure: str = ""
    """Why the picture was not looked at; "" = it was"""
    retryable: bool = False
    """Where it was not: it may be a little later"""

    @property
    def vetoed(self) -> bool:
        """Tell whether the place is on the list."""
        return bool(self.hits) or self.named != ""

    def refusal(self, unchecked: UncheckedVeto) -> str:
        """Return why the target is not to be confirmed, for the operator; "" = it may be.

        Args:
            unchecked: What follows where the picture could not be looked at.
        """
        if self.named:
            return (
                f"You named '{self.named}', which I never touch (veto list). Nothing moves. "
                "Name another place."
            )
        if self.hits:
            hit = self.hits[0]
            return (
                f"I see '{hit.phrase}' at the target ({hit.heat:.2f}, limit {hit.limit:.2f}), "
                "which I never touch (veto list). Nothing moves. Move the target away from it, "
                "or name another place."
            )
        if self.failure and unchecked == "refuse":
            return (
                f"I could not look for what I must not touch: {self.failure}. Nothing moves. "
                "Confirm again when grounding answers (`w2c status`)."
            )
        return ""


def unknown_text(phrases: tuple[str, ...]) -> str:
    """Return what is not looked for, for the operator."""
    names = ", ".join(f"'{phrase}'" for phrase in phrases)
    return f"the vision model does not know {names}: not looked for"
