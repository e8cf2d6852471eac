"""What all of the compiler uses: stages, limits, resources, plug-ins, texts of TOML and XML."""
