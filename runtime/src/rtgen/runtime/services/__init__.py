"""Service ports: servants, stubs and skeletons, connections and transports of calls."""
