"""GPano, the words by which viewers know a panorama, in files whose library does not write them.

They are XMP: an APP1 segment of a JPEG file, a text chunk of a PNG file.
"""

from __future__ import annotations

import zlib
from pathlib import Path

__all__ = ["with_panorama"]

# Google's Photo Sphere XMP: the whole sphere, nothing cut off.
_PACKET = """<x:xmpmeta xmlns:x="adobe:ns:meta/">\
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">\
<rdf:Description rdf:about="" xmlns:GPano="http://ns.google.com/photos/1.0/panorama/" \
GPano:ProjectionType="equirectangular" GPano:UsePanoramaViewer="True" \
GPano:FullPanoWidthPixels="{width}" GPano:FullPanoHeightPixels="{height}" \
GPano:CroppedAreaImageWidthPixels="{width}" GPano:CroppedAreaImageHeightPixels="{height}" \
GPano:CroppedAreaLeftPixels="0" GPano:CroppedAreaTopPixels="0"/></rdf:RDF></x:xmpmeta>"""


def with_panorama(place: Path, width: int, height: int) -> None:
    """Let a .jpg or .png file say that it is a whole latlong; leave others alone."""
    packet = _PACKET.format(width=width, height=height).encode()
    data = place.read_bytes() if place.suffix.lower() in (".jpg", ".jpeg", ".png") else b""
    if data.startswith(b"\xff\xd8"):
        segment = b"http://ns.adobe.com/xap/1.0/\0" + packet
        # Before the first that is no JFIF header, which must stand first.
        at = 2
        if data[2:4] == b"\xff\xe0":
            at = 4 + int.from_bytes(data[4:6], "big")
        size = (len(segment) + 2).to_bytes(2, "big")
        place.write_bytes(data[:at] + b"\xff\xe1" + size + segment + data[at:])
    elif data.startswith(b"\x89PNG"):
        chunk = b"iTXtXML:com.adobe.xmp\0\0\0\0\0" + packet
        ends = (len(chunk) - 4).to_bytes(4, "big"), zlib.crc32(chunk).to_bytes(4, "big")
        # After the signature and the header chunk, which must stand first.
        place.write_bytes(data[:33] + ends[0] + chunk + ends[1] + data[33:])
