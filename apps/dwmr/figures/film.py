"""Encoding of animation frames: GIF with Pillow, MP4 with the program ffmpeg; one frame as PNG."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import matplotlib
import numpy as np
import PIL
from PIL import Image, ImageColor
from PIL.GifImagePlugin import getdata, getheader

from dwmr.core.arrays import FloatArray

#: Fastest rate of a GIF: a delay is a whole number of hundredths of a second, and viewers slow one of 1 down.
FASTEST_GIF = 50.0
#: Comment of a GIF: pictures of one version are alike.
DRAWN_BY = f"Matplotlib {matplotlib.__version__}, Pillow {PIL.__version__}"
#: Number of a pixel that is as in the picture before, which takes few bytes; its colour is that of number 0.
UNCHANGED = 255


class FilmError(Exception):
    """Raised when ffmpeg cannot write a film, with its message."""


def has_ffmpeg() -> bool:
    """Return whether the program ffmpeg is there."""
    return shutil.which("ffmpeg") is not None


def write_gif(path: Path, pictures: Iterable[FloatArray], rate: float, colours: Sequence[str]) -> None:
    """Write pictures, one after the other as they come, as a GIF that repeats for ever.

    Args:
        path: File to write.
        pictures: Of shape (height, width, 3) each; at least one.
        rate: Pictures in a second; delays are rounded so that the whole keeps its time.
        colours: Colours of the palette besides those of the first picture, as #rrggbb.
    """
    last: FloatArray | None = None
    with path.open("wb") as file:
        # Pillow's own way to save an animation keeps all pictures in memory first
        for k, image in enumerate(_in_one_palette(pictures, colours)):
            indices = np.array(image)
            indices[indices == UNCHANGED] = 0
            image.putdata(indices.ravel())
            if last is None:
                file.writelines(getheader(image, info={"loop": 0, "comment": DRAWN_BY})[0])
                box = (0, 0, *image.size)
            else:
                changed = indices != last
                box = _box(changed)
                image.putdata(np.where(changed, indices, UNCHANGED).ravel())
            file.writelines(getdata(image.crop(box), box[:2], duration=_delay(k, rate), transparency=UNCHANGED))
            last = indices
        file.write(b";")


def _box(changed: FloatArray) -> tuple[int, int, int, int]:
    """Return left, upper, right and lower border of the changed part, at least one pixel."""
    rows, columns = (np.flatnonzero(changed.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return 0, 0, 1, 1
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def _in_one_palette(pictures: Iterable[FloatArray], colours: Sequence[str]) -> Iterator[Image.Image]:
    """Give all pictures the colours of the first one and some more, so that unchanged parts need no bytes."""
    palette = None
    for picture in pictures:
        image = Image.fromarray(picture)
        if palette is None:
            palette = _palette(image, colours)
        yield image.quantize(palette=palette, dither=Image.Dither.NONE)


def _palette(image: Image.Image, colours: Sequence[str]) -> Image.Image:
    """Return an image with a palette of a picture's own colours and of others, each exactly."""
    colors = image.quantize(colors=UNCHANGED - len(colours), method=Image.Quantize.MEDIANCUT).getpalette() or []
    added = [value for colour in colours for value in ImageColor.getrgb(colour)[:3]]
    result = Image.new("P", (1, 1))
    result.putpalette([*colors, *added, *([0] * (3 * UNCHANGED - len(colors) - len(added))), *colors[:3]])
    return result


def _delay(k: int, rate: float) -> int:
    """Return how long picture `k` is shown [ms], a multiple of 10."""
    begin, end = (round(100 * n / rate) for n in (k, k + 1))
    return 10 * (end - begin)


def write_png(path: Path, picture: FloatArray) -> None:
    """Write one picture of shape (height, width, 3) as a PNG."""
    Image.fromarray(picture).save(path, format="PNG")


def write_mp4(path: Path, pictures: Iterable[FloatArray], rate: float, size: tuple[int, int]) -> None:
    """Write pictures as an MP4 (H.264), sent to ffmpeg one by one.

    Args:
        path: File to write.
        pictures: Of shape (height, width, 3) each.
        rate: Pictures in a second.
        size: Width and height, even [pixels].

    Raises:
        FilmError: When ffmpeg fails.
    """
    command = [
        "ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24",
        "-video_size", f"{size[0]}x{size[1]}", "-framerate", f"{rate:g}", "-i", "-",
        "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart", "-f", "mp4", str(path),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as messages:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=messages) as program:
            assert program.stdin is not None
            try:
                for picture in pictures:
                    program.stdin.write(picture.tobytes())
                program.stdin.close()
            except BrokenPipeError:  # it has ended, and its message explains why
                pass
            except BaseException:
                program.kill()
                raise
        if program.returncode:
            messages.seek(0)
            lines = messages.read().decode(errors="replace").split("\n")
            raise FilmError(next((line.strip() for line in reversed(lines) if line.strip()), "it gives no reason"))
