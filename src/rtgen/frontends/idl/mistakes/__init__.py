"""Turns parser errors into diagnostics about their likely cause, and decides how to recover."""

from rtgen.frontends.idl.mistakes.characters import bad_character, is_blank, meant
from rtgen.frontends.idl.mistakes.recognisers import explain
from rtgen.frontends.idl.mistakes.situation import Mistake, Situation

__all__ = ["Mistake", "Situation", "bad_character", "explain", "is_blank", "meant"]
