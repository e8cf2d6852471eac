"""Systems of components: requests, schedulers in real and simulated time, observation."""
