"""From bytes to a preprocessed unit: files, macros, conditions, `#include` and `import`."""
