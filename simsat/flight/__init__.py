"""One flight: settings become plant, environment and controller, and the loop closes them."""
