"""Chats to prompts, by the model's own template; no text of a message can leave its turn."""

import json
import re
from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import Any

import jinja2
from jinja2.ext import loopcontrols
from jinja2.sandbox import ImmutableSandboxedEnvironment

from w2c.errors import ModelError, RefusedError
from w2c.messages import ChatMessage

_SYSTEM_PROBE = (
    ChatMessage(role="system", content="instructions"),
    ChatMessage(role="user", content="question"),
)


class ChatTemplate:
    """Renders chats for one model."""

    def __init__(
        self,
        template: str,
        begin: str,
        end: str,
        control_texts: Iterable[str],
        *,
        thinking: bool = False,
    ) -> None:
        """Compile a template.

        Args:
            template: Jinja source from the model's file.
            begin: How the beginning-of-text token is written.
            end: How the end-of-text token is written.
            control_texts: What no message may hold.
            thinking: Passed to templates that know the switch `enable_thinking`.

        Raises:
            ModelError: the template is not Jinja, or cannot render a chat at all.
        """
        environment = ImmutableSandboxedEnvironment(
            trim_blocks=True, lstrip_blocks=True, extensions=[loopcontrols]
        )
        environment.filters["tojson"] = _to_json
        environment.globals.update(
            raise_exception=_raise_exception,
            strftime_now=lambda form: datetime.now().astimezone().strftime(form),
        )
        try:
            self._template = environment.from_string(template)
        except jinja2.TemplateError as error:
            raise ModelError(f"the chat template of the model is not valid: {error}") from error
        self._values = {"bos_token": begin, "eos_token": end, "enable_thinking": thinking}
        longest_first = sorted(control_texts, key=len, reverse=True)
        self._control = re.compile("|".join(map(re.escape, longest_first)) or r"(?!)")
        self.system_role = self._accepts_system_role()

    def render(self, messages: Sequence[ChatMessage], *, answer_follows: bool = True) -> str:
        """Return the prompt of a chat; `answer_follows` opens the turn of the assistant.

        Raises:
            RefusedError: a message holds a control token, or the template refuses the chat.
        """
        for message in messages:
            found = self._control.search(message.content)
            if found:
                raise RefusedError(
                    f"a message of the {message.role} holds '{found.group()}', "
                    "a control token of the model; "
                    "leave it out"
                )
        try:
            chat = messages if self.system_role else merge_system(messages)
            return self._render(chat, answer_follows)
        except jinja2.TemplateError as error:
            raise RefusedError(
                f"the chat template of the model refuses this chat: {error}"
            ) from error

    def _render(self, messages: Sequence[ChatMessage], answer_follows: bool) -> str:
        turns = [{"role": message.role, "content": message.content} for message in messages]
        return self._template.render(
            messages=turns, add_generation_prompt=answer_follows, **self._values
        )

    def _accepts_system_role(self) -> bool:
        """Return whether the template has a system role (Gemma-2's, for one, refuses it)."""
        try:
            return "instructions" in self._render(_SYSTEM_PROBE, True)
        except jinja2.TemplateError:
            return False


def merge_system(messages: Sequence[ChatMessage]) -> list[ChatMessage]:
    """Return the chat with each system message put in front of the user's that follows."""
    merged: list[ChatMessage] = []
    pending: list[str] = []
    for message in messages:
        if message.role == "system":
            pending.append(message.content)
        elif message.role == "user" and pending:
            content = "\n\n".join([*pending, message.content])
            merged.append(ChatMessage(role="user", content=content))
            pending = []
        else:
            merged.append(message)
    if pending:  # a prefix that ends with a system message
        merged.append(ChatMessage(role="user", content="\n\n".join(pending)))
    return merged


def _to_json(value: Any, indent: int | None = None) -> str:
    return json.dumps(value, ensure_ascii=False, indent=indent)


def _raise_exception(message: str) -> None:
    raise jinja2.TemplateError(message)
