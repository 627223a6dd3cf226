"""Recordings: what robots' loggers wrote, read, checked, cleaned and written again."""

from morph.record.load import check_distinct as check_distinct
from morph.record.load import load as load
from morph.record.recording import Channel as Channel
from morph.record.recording import Note as Note
from morph.record.recording import Recording as Recording
