"""`w2c ground models`: the public models by name, which of them are here, and whose licence."""

from collections.abc import Callable, Iterable

from w2c_grounding.known import KNOWN, KnownModel

_WEIGHTS = (
    "model.safetensors",
    "model.safetensors.index.json",
    "pytorch_model.bin",
    "pytorch_model.bin.index.json",
)


def describe_models(models: Iterable[KnownModel], is_here: Callable[[KnownModel], bool]) -> str:
    """Return two lines a model: name, family, what it gives, where it is; hub id and licence."""
    lines = [
        "embedded                 clipseg         heatmap  here",
        "    with this project, Apache-2.0; what is loaded without --model",
    ]
    for model in models:
        source = f" ({model.licence_source})" if model.licence_source else ""
        lines += [
            f"{model.name:24} {model.family:15} {model.gives:8} {_place(model, is_here)}",
            f"    {model.model}, licence: {model.licence}{source}",
        ]
    lines += [
        "Nothing is fetched by itself. To fetch and try one:",
        '    w2c ground "the cup" --image FILE --model NAME --allow-download',
        'A licence "not checked" is from memory: read the page of the model first.',
    ]
    return "\n".join(lines)


def models_table() -> str:
    """Return the public models as a table in Markdown."""
    lines = [
        "| `--model` | hub id | family | answers with | licence (where read) | MB |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| `{model.name}` | {model.model} | {model.family} | {model.gives} | {model.licence} "
        f"({model.licence_source}) | {model.megabytes or '?'} |"
        for model in KNOWN.values()
    ]
    return "\n".join(lines)


def _place(model: KnownModel, is_here: Callable[[KnownModel], bool]) -> str:
    if is_here(model):
        return "here"
    size = "size not known" if model.megabytes is None else f"{model.megabytes} MB"
    return f"not here; to fetch: {size}"


def is_in_cache(model: KnownModel) -> bool:
    """Return whether the hub's cache on this machine holds a model; asks no network."""
    from huggingface_hub import try_to_load_from_cache

    revision = model.revision or None

    def has(name: str) -> bool:
        # What is known not to exist on the hub is an object, not a path.
        return isinstance(try_to_load_from_cache(model.model, name, revision=revision), str)

    return has("config.json") and any(has(name) for name in _WEIGHTS)
