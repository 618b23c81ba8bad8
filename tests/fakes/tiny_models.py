"""Checkpoint directories of public architectures with random weights: made in a second, a megabyte.

Their files have the layout of the first public checkpoints (vocab.txt, vocab.json and merges.txt,
preprocessor_config.json), which is what is on the hub.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch

from w2c_grounding.train.model import Size
from w2c_grounding.train.tokens import START, learn_merges, make_vocabulary

WORDS = ("the", "a", "red", "blue", "green", "book", "cup", "square", "photo", "of", "inch", "disk")
LONGEST_TEXT = 24
TINY = Size(
    image=64,
    patch=16,
    width=32,
    layers=2,
    heads=2,
    extract=(0, 1),
    text_width=32,
    text_layers=1,
    projection=16,
    reduced=16,
)
"""Of a checkpoint of this project's own layout"""

# Of bert-base-uncased; transformers looks for them by these numbers.
_BERT_TOKENS = {0: "[PAD]", 100: "[UNK]", 101: "[CLS]", 102: "[SEP]", 103: "[MASK]"}
_BERT_TOKENS |= {1012: ".", 1029: "?"}


def tiny_grounding_dino(
    directory: Path, *, mm: bool = False, seed: int = 3, words: Sequence[str] = WORDS
) -> Path:
    """Write a GroundingDINO, or an MM-GroundingDINO, for small pictures; return its directory."""
    from transformers import (
        BertConfig,
        GroundingDinoConfig,
        GroundingDinoForObjectDetection,
        MMGroundingDinoConfig,
        MMGroundingDinoForObjectDetection,
        SwinConfig,
    )

    kind: Any = MMGroundingDinoForObjectDetection if mm else GroundingDinoForObjectDetection
    swin: Any = SwinConfig
    configuration: Any = MMGroundingDinoConfig if mm else GroundingDinoConfig
    tokens = dict(_BERT_TOKENS)
    tokens |= {1030 + index: word for index, word in enumerate(words)}
    tokens |= {1100 + index: f"{index}" for index in range(10)}
    size = max(tokens) + 1
    vocabulary = [tokens.get(index, f"[unused{index}]") for index in range(size)]
    torch.manual_seed(seed)
    model = kind(
        configuration(
            backbone_config=swin(
                image_size=64,
                embed_dim=16,
                depths=[1, 1, 1, 1],
                num_heads=[2, 2, 2, 2],
                window_size=4,
                out_features=["stage2", "stage3", "stage4"],
            ),
            text_config=BertConfig(
                vocab_size=size,
                hidden_size=32,
                num_hidden_layers=1,
                num_attention_heads=2,
                intermediate_size=32,
                max_position_embeddings=64,
            ),
            d_model=32,
            encoder_layers=2,
            decoder_layers=2,
            encoder_attention_heads=2,
            decoder_attention_heads=2,
            encoder_ffn_dim=32,
            decoder_ffn_dim=32,
            num_queries=20,
            max_text_len=LONGEST_TEXT,
        )
    )
    model.save_pretrained(directory)
    (directory / "vocab.txt").write_text("\n".join(vocabulary) + "\n")
    _write(directory / "tokenizer_config.json", tokenizer_class="BertTokenizer", do_lower_case=True)
    _write(
        directory / "preprocessor_config.json",
        image_processor_type="GroundingDinoImageProcessor",
        processor_class="GroundingDinoProcessor",
        size={"shortest_edge": 64, "longest_edge": 107},
        do_pad=True,
        image_mean=[0.485, 0.456, 0.406],
        image_std=[0.229, 0.224, 0.225],
    )
    return directory


def tiny_owlv2(directory: Path, seed: int = 3) -> Path:
    """Write an OWLv2 for squares of 64 px; return its directory."""
    from transformers import Owlv2Config, Owlv2ForObjectDetection

    torch.manual_seed(seed)
    size = _write_clip_tokenizer(directory, longest=16)
    model: Any = Owlv2ForObjectDetection(
        Owlv2Config(
            text_config=_text_config(size, longest=16),
            vision_config=_vision_config(),
            projection_dim=32,
        )
    )
    model.save_pretrained(directory)
    _write(
        directory / "preprocessor_config.json",
        image_processor_type="Owlv2ImageProcessor",
        processor_class="Owlv2Processor",
        size={"height": 64, "width": 64},
        image_mean=[0.481, 0.458, 0.408],
        image_std=[0.269, 0.261, 0.276],
    )
    return directory


def tiny_clip(directory: Path, seed: int = 3) -> Path:
    """Write a CLIP for squares of 64 px; return its directory."""
    from transformers import CLIPConfig, CLIPModel

    torch.manual_seed(seed)
    size = _write_clip_tokenizer(directory, longest=LONGEST_TEXT)
    model: Any = CLIPModel(
        CLIPConfig(
            text_config=_text_config(size, longest=LONGEST_TEXT),
            vision_config=_vision_config(),
            projection_dim=32,
        )
    )
    model.save_pretrained(directory)
    _write(
        directory / "preprocessor_config.json",
        feature_extractor_type="CLIPFeatureExtractor",
        do_resize=True,
        size=64,
        do_center_crop=True,
        crop_size=64,
        resample=3,
        do_normalize=True,
        image_mean=[0.481, 0.458, 0.408],
        image_std=[0.269, 0.261, 0.276],
    )
    return directory


def _text_config(size: int, longest: int) -> dict[str, Any]:
    return {
        "vocab_size": size,
        "hidden_size": 32,
        "intermediate_size": 32,
        "num_hidden_layers": 1,
        "num_attention_heads": 2,
        "max_position_embeddings": longest,
        "bos_token_id": size - 2,
        "eos_token_id": size - 1,
        "pad_token_id": size - 1,
    }


def _vision_config() -> dict[str, Any]:
    return {
        "hidden_size": 32,
        "intermediate_size": 32,
        "num_hidden_layers": 8,
        "num_attention_heads": 2,
        "image_size": 64,
        "patch_size": 16,
    }


def _write_clip_tokenizer(directory: Path, longest: int) -> int:
    """Write vocab.json and merges.txt; return the size of the vocabulary."""
    merges = learn_merges(WORDS)
    vocabulary = make_vocabulary(merges)
    directory.mkdir(parents=True, exist_ok=True)
    (directory / "vocab.json").write_text(json.dumps(vocabulary))
    lines = ["#version: 0.2", *(" ".join(pair) for pair in merges)]
    (directory / "merges.txt").write_text("\n".join(lines) + "\n")
    end = next(token for token, index in vocabulary.items() if index == len(vocabulary) - 1)
    _write(
        directory / "tokenizer_config.json",
        tokenizer_class="CLIPTokenizer",
        model_max_length=longest,
        bos_token=START,
        eos_token=end,
        unk_token=end,
        pad_token=end,
    )
    return len(vocabulary)


def _write(path: Path, **values: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(values))
