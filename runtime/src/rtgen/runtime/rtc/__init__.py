"""Components and execution contexts (OMG RTC 1.0): life cycle, callbacks, configuration sets."""
