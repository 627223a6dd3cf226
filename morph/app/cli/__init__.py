"""The terminal: `morph diagnose`, `morph list`."""

from morph.app.cli.main import main as main
