"""Write the films into a folder: python -m lab.films --out DIR."""

import argparse
import re
from pathlib import Path

from lab.films.film_file import write_film
from lab.films.listing import composed_films, mesh_films


def main() -> None:
    """Render every film whose name contains a text, each into a folder of its own."""
    parser = argparse.ArgumentParser(prog="python -m lab.films", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder that receives a folder for each film")
    parser.add_argument("--only", default="", help="only films whose name contains this")
    parser.add_argument("--seed", type=int, default=1, help="of rooms, light and tremor")
    options = parser.parse_args()
    for film in [*mesh_films(options.seed), *composed_films(options.seed)]:
        if options.only in film.name:
            folder = options.out / re.sub(r"[^a-z0-9]+", "_", film.name)
            print(f"{folder}: {write_film(film, folder)} instants", flush=True)


if __name__ == "__main__":
    main()
