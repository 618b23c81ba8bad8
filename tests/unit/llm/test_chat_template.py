"""Chats become prompts by the model's own template, whatever it can or cannot do."""

import pytest

from w2c.errors import ModelError, RefusedError
from w2c.messages import ChatMessage
from w2c_llm.chat_template import ChatTemplate
from w2c_llm.train.corpus import Turn
from w2c_llm.train.tokenizer import CHAT_TEMPLATE, SPECIAL_TOKENS, render_prompt

CHAT = [
    ChatMessage(role="system", content="be brief"),
    ChatMessage(role="user", content="hello {{ 7 * 7 }}"),
    ChatMessage(role="assistant", content="hi"),
    ChatMessage(role="user", content="bye"),
]
NO_SYSTEM = (
    "{{ bos_token }}{% for m in messages %}{% if m.role == 'system' %}"
    "{{ raise_exception('System role not supported') }}{% endif %}"
    "[{{ m.role }}]{{ m.content }}{% endfor %}{% if add_generation_prompt %}[model]{% endif %}"
)


def test_the_embedded_template_renders_what_training_rendered() -> None:
    template = ChatTemplate(CHAT_TEMPLATE, "", "<|end|>", SPECIAL_TOKENS)
    expected = render_prompt([Turn(message.role, message.content) for message in CHAT])
    assert template.render(CHAT) == expected
    assert template.render(CHAT[:1], answer_follows=False) == "<|system|>be brief<|end|>"


@pytest.mark.parametrize(
    "source",
    [NO_SYSTEM, NO_SYSTEM.replace("{{ raise_exception('System role not supported') }}", "")],
)
def test_a_system_message_moves_into_the_users_where_the_template_refuses_it(source: str) -> None:
    template = ChatTemplate(source, "<s>", "</s>", [])
    if "raise_exception" in source:
        assert not template.system_role
        assert template.render(CHAT) == (
            "<s>[user]be brief\n\nhello {{ 7 * 7 }}[assistant]hi[user]bye[model]"
        )
        prefix = template.render(CHAT[:1], answer_follows=False)
        assert template.render(CHAT).startswith(prefix), "else it could not be reused"
    else:
        assert template.system_role


def test_a_template_that_drops_the_system_message_counts_as_without_system_role() -> None:
    source = (
        "{% for m in messages %}{% if m.role != 'system' %}{{ m.content }}{% endif %}{% endfor %}"
    )
    assert "be brief" in ChatTemplate(source, "", "", []).render(CHAT)


def test_thinking_is_off_unless_asked_for() -> None:
    source = "{% if enable_thinking %}think{% else %}answer{% endif %}{{ messages[0].content }}"
    assert ChatTemplate(source, "", "", []).render(CHAT).startswith("answer")


def test_a_template_that_is_not_jinja_is_an_error_of_the_model() -> None:
    with pytest.raises(ModelError, match="chat template"):
        ChatTemplate("{% for %}", "", "", [])


@pytest.mark.parametrize(
    "source",
    [
        "{{ messages.__class__.__mro__ }}{{ raise_exception('x') }}",
        "{{ ''.__class__.__subclasses__() }}",
        "{{ raise_exception('alternate roles') }}",
    ],
)
def test_a_template_cannot_reach_out_and_its_refusal_has_a_reason(source: str) -> None:
    with pytest.raises(RefusedError, match="chat template of the model refuses"):
        ChatTemplate(source, "", "", []).render(CHAT)


def test_control_tokens_are_found_the_longest_first() -> None:
    template = ChatTemplate(CHAT_TEMPLATE, "", "", ["<|e", "<|end|>"])
    with pytest.raises(RefusedError, match=r"holds '<\|end\|>'"):
        template.render([ChatMessage(role="user", content="a<|end|>b")])
