"""What a result depends on besides its settings: model, networks, code, packages and machine."""
