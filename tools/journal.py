"""What a script that runs for minutes says on the terminal."""

import time


class Journal:
    """Runs steps, says on the terminal what happens, and keeps the seconds that each step took."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    def run(self, step: str, label: str, work, *arguments, **options):
        print(f"{label:<34}", end="", flush=True)
        start = time.perf_counter()
        try:
            result = work(*arguments, **options)
        except BaseException:
            print(flush=True)
            raise
        self.seconds[step] = self.seconds.get(step, 0.0) + time.perf_counter() - start
        print(f"{time.perf_counter() - start:6.1f} s", flush=True)
        return result
