"""Syntax errors in a user's words: what the parser found, told as the mistake that it likely is."""

from rtgen.frontends.idl.mistakes.characters import bad_character, is_blank, meant
from rtgen.frontends.idl.mistakes.recognisers import explain
from rtgen.frontends.idl.mistakes.situation import Mistake, Situation

__all__ = ["Mistake", "Situation", "bad_character", "explain", "is_blank", "meant"]
