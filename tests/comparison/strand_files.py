"""Runs the tool, and reads the strands that it exports as text."""

import json
import subprocess

import numpy as np


def pelage(binary, *words):
    """Runs a subcommand and returns the JSON object that it prints."""
    result = subprocess.run([binary, *map(str, words), "--json", "-q"], check=True, capture_output=True, text=True)
    return json.loads(result.stdout)


def read_text(path):
    """Returns strands as arrays of rows x y z radius, in binary32 as written."""
    text = path.read_text(encoding="utf-8").strip()
    blocks = text.split("\n\n") if text else []
    return [np.array([line.split() for line in block.splitlines()], dtype=np.float32) for block in blocks]
