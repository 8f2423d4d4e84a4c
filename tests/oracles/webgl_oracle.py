"""WebGL 2 in Chromium: a fragment shader on rows of numbers, with four numbers a target."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np

# A full-screen triangle; each pixel is a row, given and made in textures of float32. The program
# runs on each table, and knows by `verb` which it is.
SCRIPT = """([source, tables, width, count]) => {
    const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
    if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("no float targets");
    const vertex = `#version 300 es
        void main() {
            gl_Position = vec4(ivec2(gl_VertexID & 1, gl_VertexID >> 1) * 4 - 1, 0, 1);
        }`;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, source]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (gl.getShaderInfoLog(shader)) throw new Error(gl.getShaderInfoLog(shader));
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (gl.getProgramInfoLog(program)) throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    const decoded = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
    const encoded = (numbers) => {
        let text = "";
        const all = new Uint8Array(numbers.buffer);
        for (let k = 0; k < all.length; k += 8192)
            text += String.fromCharCode(...all.subarray(k, k + 8192));
        return btoa(text);
    };
    const run = (table, number) => {
        const given = new Float32Array(decoded(table)), height = given.length / 4 / width;
        const textures = Array.from({ length: count + 1 }, () => {
            const texture = gl.createTexture();
            gl.bindTexture(gl.TEXTURE_2D, texture);
            gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
            return texture;
        });
        gl.bindTexture(gl.TEXTURE_2D, textures[0]);
        gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, given);
        gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
        const targets = textures.slice(1).map((_, k) => gl.COLOR_ATTACHMENT0 + k);
        targets.forEach((target, k) =>
            gl.framebufferTexture2D(gl.FRAMEBUFFER, target, gl.TEXTURE_2D, textures[k + 1], 0));
        gl.drawBuffers(targets);
        gl.viewport(0, 0, width, height);
        gl.uniform1i(gl.getUniformLocation(program, "verb"), number);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        return targets.map((target) => {
            const numbers = new Float32Array(4 * width * height);
            gl.readBuffer(target);
            gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, numbers);
            return encoded(numbers);
        });
    };
    const made = tables.map(run);
    const wrong = gl.getError();
    gl.getExtension("WEBGL_lose_context").loseContext();
    if (wrong) throw new Error(`WebGL error ${wrong}`);
    return made;
}"""
WIDTH = 256


def run(page: Any, source: str, tables: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return (n, 4 targets) float32 of each table: what a shader writes for rows of numbers.

    The rows, of up to four, are texels of its texture `given`; its uniform `verb` is the number of
    the table.
    """

    def text(rows: np.ndarray) -> str:
        given = np.zeros((-(-len(rows) // WIDTH) * WIDTH, 4), np.float32)
        given[: len(rows), : rows.shape[1]] = rows
        return base64.b64encode(given.tobytes()).decode()

    count = source.count("layout(location = ")
    made = page.evaluate(SCRIPT, [source, [text(rows) for rows in tables], WIDTH, count])
    return [
        np.concatenate(
            [np.frombuffer(base64.b64decode(part), np.float32).reshape(-1, 4) for part in parts],
            axis=1,
        )[: len(rows)]
        for rows, parts in zip(tables, made, strict=True)
    ]
