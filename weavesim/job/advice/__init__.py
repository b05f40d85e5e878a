"""What a new set-up is advised: speeds and damping, with the reasons."""
