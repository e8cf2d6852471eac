"""RtcProfile: rules, escapes, dates, and facts that its attributes cannot express."""
