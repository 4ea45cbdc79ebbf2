"""A child within limits that counts the formats that it finds."""

from workbench.ipc.limited import serve_one_request
from workbench.plant.readers import description_formats, rotor_dialects, world_formats


def answer(_: object) -> list[int]:
    return [len(found()) for found in (description_formats, rotor_dialects, world_formats)]


if __name__ == "__main__":
    serve_one_request(answer)
