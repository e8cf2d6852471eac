"""Presence between media: announcements are discovered, and so is their end."""

from __future__ import annotations

from collections.abc import Callable

from collecting import Changes
from patience import until

from rtgen.runtime.distribution.medium import Medium

Join = Callable[..., Medium]


def test_changes_are_reported_to_those_who_watch(join: Join) -> None:
    here, there = join(), join()
    early, late, other = Changes(), Changes(), Changes()
    here.watch("robot/", early.on_change)
    token = there.announce("robot/arm")
    until(lambda: early)
    join().watch("rob", late.on_change)
    here.watch("robot/arm/x", other.on_change)
    until(lambda: late)
    token.close()
    token.close()
    until(lambda: len(early) == len(late) == 2)
    again = there.announce("robot/arm")
    until(lambda: len(early) == 3)
    wanted = [("robot/arm", True), ("robot/arm", False), ("robot/arm", True)]
    assert early == wanted
    assert not other
    again.close()


def test_a_name_ends_with_the_last_that_announced_it(join: Join) -> None:
    watcher, one, two = join(), join(), join()
    seen, own = Changes(), Changes()
    watcher.watch("", seen.on_change)
    one.watch("", own.on_change)
    first, second = one.announce("a/b"), two.announce("a/b")
    until(lambda: seen and own)
    mark = two.announce("mark")
    until(lambda: ("mark", True) in seen and ("mark", True) in own)
    first.close()
    mark.close()
    until(lambda: ("mark", False) in seen and ("mark", False) in own)
    assert ("a/b", False) not in seen
    second.close()
    until(lambda: ("a/b", False) in seen and ("a/b", False) in own)
    assert seen.count(("a/b", True)) == own.count(("a/b", True)) == 1


def test_what_a_medium_announced_ends_with_it(join: Join) -> None:
    watcher, other = join(), join()
    seen = Changes()
    watcher.watch("x", seen.on_change)
    other.announce("x/1")
    other.announce("x/2")
    until(lambda: len(seen) == 2)
    other.close()
    other.close()
    until(lambda: len(seen) == 4)
    assert sorted(seen[2:]) == [("x/1", False), ("x/2", False)]


def test_a_watch_that_is_closed_reports_nothing(join: Join) -> None:
    here, there = join(), join()
    closed, seen = Changes(), Changes()
    watch = here.watch("", closed.on_change)
    here.watch("", seen.on_change)
    watch.close()
    there.announce("x")
    until(lambda: seen)
    assert not closed


def test_systems_do_not_see_each_other(join: Join) -> None:
    here, elsewhere, there = join(), join("another"), join()
    seen = Changes()
    here.watch("", seen.on_change)
    elsewhere.announce("stranger")
    there.announce("member")
    until(lambda: seen)
    assert seen == [("member", True)]
