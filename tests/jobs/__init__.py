"""Jobs written as TOML."""
