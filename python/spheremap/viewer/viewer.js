// The page of sm.view: one canvas, one triangle, shaders whose maps the library printed.
//
// mount(element, scene) draws; it returns a handle with `look`, `set`, `pick`, `draw` and `ready`.
// A scene is what viewer/page.py writes. Nothing is fetched. `render` is the same for a widget.

const VERTEX = `#version 300 es
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;
const AXES = { "+x": [1, 0, 0], "-x": [-1, 0, 0], "+y": [0, 1, 0], "-y": [0, -1, 0], "+z": [0, 0, 1], "-z": [0, 0, -1] };
const FOV = [15, 340];
// Beyond it a perspective becomes a little planet.
const WIDEST_PERSPECTIVE = 170;
const COMPARISONS = ["first", "second", "split", "difference", "signed", "blink"];
// Of directions that are placed on screens, in a row of their texture.
const POINTS = 1024;
// What a program has only where it is asked for: compilers take their time, and renderers in software run all that there is.
const EXTRAS = ["false_color", "isolines", "clipping", "graticule", "valid", "density", "tissot", "seams"];
const DEGREE = Math.PI / 180;
const KEYS = [
    ["arrows", "turn (with Shift further)"], ["+ −", "closer, wider"], ["Home", "first view"],
    ["[ ]", "darker, brighter"], ["f", "false color in stops"], ["i", "isolines of stops"],
    ["c", "clipping"], ["g", "graticule"], ["a", "axes"], ["v", "what is not held"], ["d", "density"],
    ["t", "Tissot's circles"], ["s", "seams"], ["p", "next screen"],
    ["b", "beside a flat map"], ["x", "the other image"],
];

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const tail = (x) => (x === 0 ? "0" : Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(2) : x.toPrecision(4));

// Arrays -----------------------------------------------------------------------------------------

function bytesOf(text) {
    if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    return bytes;
}

async function unpacked(text, count, channels, wide) {
    const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const planes = new Uint8Array(await new Response(stream).arrayBuffer());
    const words = new (wide ? Uint16Array : Uint8Array)(count * channels);
    for (let c = 0; c < channels; c++) {
        let word = 0;
        for (let i = 0, k = c * count; i < count; i++, k++) {
            word += planes[k] + (wide ? planes[count * channels + k] << 8 : 0);
            words[i * channels + c] = word;
        }
    }
    return words;
}

function halfToNumber(bits) {
    const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 31, part = bits & 1023;
    if (exponent === 31) return part ? NaN : sign * Infinity;
    return sign * (exponent ? 2 ** (exponent - 25) * (1024 + part) : part * 2 ** -24);
}

// Halves with what they are in the fourth channel: 1 a value, 0 outside, -1 NaN.
async function textureWords(image) {
    const { faces, height, width, channels, table } = image;
    const count = faces * height * width, step = channels > 1 ? 1 : 0;
    const words = await unpacked(image.words, count, channels, table === null);
    const states = image.states && (await unpacked(image.states, count, 1, false));
    const texels = new Uint16Array(4 * count);
    for (let i = 0, j = 0, k = 0; i < count; i++, j += channels, k += 4) {
        texels[k + 3] = states ? [0, 0x3c00, 0xbc00][states[i]] : 0x3c00;
        // What is no value is black, to be between values.
        if (texels[k + 3] !== 0x3c00) continue;
        for (let c = 0, at = j; c < 3; c++, at += step) texels[k + c] = table ? table[words[at]] : words[at];
    }
    return texels;
}

// Drawing ----------------------------------------------------------------------------------------

function compiled(gl, fragment) {
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
        const logs = gl.getAttachedShaders(program).map((s) => gl.getShaderInfoLog(s)).join("\n");
        throw new Error(`shader: ${gl.getProgramInfoLog(program)}\n${logs}`);
    }
    const places = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
        const name = gl.getActiveUniform(program, i).name.replace(/\[0\]$/, "");
        places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
}

// A function with one name for maps of one face and of several.
const placed = (name, source, faces) =>
    `vec3 ${name}(vec3 d) { return ${faces > 1 ? `${source}(d)` : `vec3(${source}(d), 0.0)`}; }\n`;

// Places in an image as a person reads them, and steradians per unit of du dv.
const ownOf = ({ own, own_faces }) => [own, placed("own_place", "own_encode", own_faces),
    `float own_solid(vec3 uvf) { return own_density(${own_faces > 1 ? "uvf" : "uvf.xy"}); }`].join("\n");

class Painter {
    constructor(canvas, scene) {
        const gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
        if (!gl) throw new Error("This needs WebGL 2, which the browser does not offer.");
        Object.assign(this, { gl, canvas, scene, programs: new Map(), textures: [], texels: [], details: [] });
        gl.bindVertexArray(gl.createVertexArray());
    }

    async load() {
        this.store(await Promise.all(this.scene.images.map(textureWords)));
    }

    // Put texels of all images in the place of those that there were.
    store(all) {
        const { gl, scene } = this;
        const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
        [...this.textures, ...this.details.map((detail) => detail.texture)].forEach((texture) => gl.deleteTexture(texture));
        Object.assign(this, { textures: [], texels: all, details: [] });
        scene.images.forEach((image, k) => {
            if (Math.max(image.width, image.height) > most) {
                throw new Error(`This machine's textures end at ${most} texels: save with max_size=${most - 2}.`);
            }
            this.textures.push(this.texture([image.width, image.height, image.faces], all[k]));
            // Where there is nothing sharper, a texture of one texel stands for it.
            this.details.push({ texture: this.texture([1, 1, 1], null), pose: [1, 0, 0, 0, 1, 0, 0, 0, 1], scale: [1, 1, 0], screen: "" });
        });
        const lookups = JSON.stringify(scene.images.map(({ lookup, own }) => [lookup, own]));
        if (lookups !== this.lookups) {
            this.programs.forEach(({ program }) => gl.deleteProgram(program));
            this.programs.clear();
        }
        this.lookups = lookups;
    }

    texture([width, height, layers], words) {
        const { gl } = this;
        const texture = gl.createTexture();
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
        gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
        gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
        for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, side, gl.CLAMP_TO_EDGE);
        gl.texImage3D(gl.TEXTURE_2D_ARRAY, 0, gl.RGBA16F, width, height, layers, 0, gl.RGBA, gl.HALF_FLOAT, words);
        return texture;
    }

    // A picture by a perspective, or by a screen, that is sharper than an image: halves of RGBA.
    sharpen(which, { width, height, pose, scale, screen }, words) {
        if (!this.details[which]) return;
        this.gl.deleteTexture(this.details[which].texture);
        this.details[which] = { texture: this.texture([width, height, 1], words), pose, scale, screen };
    }

    // Whether what is sharper was made for a screen, of the images that are drawn.
    made_for(screen, look, second) {
        return [look.first, second].some((which) => this.details[which]?.screen === screen);
    }

    drop() {
        this.gl.getExtension("WEBGL_lose_context")?.loseContext();
    }

    // Directions that are placed on screens: a texture, which has room for all.
    mark(directions) {
        const { gl } = this;
        this.marks = directions.length;
        if (!this.marks) return;
        const rows = Math.ceil(this.marks / POINTS), words = new Float32Array(4 * POINTS * rows);
        directions.forEach((d, k) => words.set(d, 4 * k));
        this.points ??= gl.createTexture();
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, this.points);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, POINTS, rows, 0, gl.RGBA, gl.FLOAT, words);
    }

    // What a pair of images, a screen and a task (PICK, LOCATE or none) is drawn by.
    program(first, second, screen, task = "", extras = []) {
        const key = [first, second, screen, task, ...extras].join("|");
        if (!this.programs.has(key)) {
            const { images, screens, globe, body } = this.scene;
            const parts = ["#version 300 es", task && `#define ${task}`, screens[screen].text];
            parts.push(screens[screen].edge ? "bool screen_holds(vec2 uv) { return true; }"
                : "bool screen_holds(vec2 uv) { return screen_valid(uv); }");
            if (task === "PICK") {
                const { lookup, lookup_faces } = images[first];
                parts.push(ownOf(images[first]), lookup.replaceAll("imageN", "image0"),
                    placed("image0_place", "image0_encode", lookup_faces));
            } else if (!task) {
                parts.push(globe, this.scene.detail ? `#define DETAIL\n${this.scene.detail}` : "");
                for (const [k, which] of [first, second].entries()) {
                    if (which === null) continue;
                    const { lookup, lookup_faces } = images[which];
                    parts.push(lookup.replaceAll("imageN", `image${k}`),
                        placed(`image${k}_place`, `image${k}_encode`, lookup_faces));
                }
                if (second !== null) parts.push("#define SECOND");
                parts.push(...extras.map((part) => `#define ${part.toUpperCase()}`));
                if (extras.includes("density")) parts.push(ownOf(images[first]));
            }
            parts.push(body);
            this.programs.set(key, compiled(this.gl, parts.join("\n")));
        }
        return this.programs.get(key);
    }

    aim({ places }, view) {
        const { gl } = this;
        gl.uniform4f(places.rect, ...view.rect);
        gl.uniform2f(places.scale, ...view.scale);
        gl.uniformMatrix3fv(places.pose, false, view.pose);
    }

    // The program of a view: at rest, or while it moves.
    drawing(view, look, moving) {
        const second = look.comparison === "first" || this.scene.images.length < 2 ? null : look.second;
        const extras = EXTRAS.filter((part) => look[part]);
        if (this.scene.detail && this.made_for(view.screen, look, second)) extras.push("own_screen");
        return { second, made: this.program(look.first, second, view.screen, "", moving ? [...extras, "moving"] : extras) };
    }

    picture(view, look, samples) {
        const { gl, scene } = this;
        const { second, made } = this.drawing(view, look, samples === 1);
        const { places } = made;
        gl.useProgram(made.program);
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(...view.rect);
        this.aim(made, view);
        for (const [k, which] of [look.first, second].entries()) {
            if (which === null) continue;
            gl.activeTexture(gl.TEXTURE0 + k);
            gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.textures[which]);
            gl.uniform4f(places[`grids[${k}].place`], ...scene.images[which].place);
            gl.uniform1f(places[`grids[${k}].gain`], scene.images[which].gain);
        }
        gl.uniform1iv(places.texels, [0, second === null ? 0 : 1]);
        if (scene.detail) {
            const details = [look.first, second ?? look.first].map((which) => this.details[which]);
            details.forEach(({ texture }, k) => {
                gl.activeTexture(gl.TEXTURE2 + k);
                gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
            });
            gl.uniform1iv(places.details, [2, 3]);
            gl.uniformMatrix3fv(places.detail_pose, false, details.flatMap(({ pose }) => pose));
            const kind = this.made_for(view.screen, look, second) ? view.screen : "";
            gl.uniform3fv(places.detail_scale, details.flatMap(({ scale, screen }) => (screen === kind ? scale : [1, 1, 0])));
        }
        const blink = look.comparison === "blink";
        const mode = blink ? (look.blinked ? 1 : 0) : COMPARISONS.indexOf(look.comparison);
        gl.uniform1i(places.comparison, second === null ? 0 : mode);
        gl.uniform1f(places.split, look.split);
        gl.uniform1f(places.exposure, look.exposure);
        gl.uniform1i(places.curve, scene.curves.indexOf(look.curve));
        gl.uniform1f(places.white, scene.white);
        gl.uniform3fv(places.ramp, scene.ramp.flat());
        gl.uniform1f(places.graticule, look.graticule);
        if (look.tissot) gl.uniform2fv(places.circles, scene.tissot);
        if (look.density) gl.uniform1f(places.mean_density, scene.images[look.first].mean_density);
        gl.uniform3fv(places.outside, scene.outside);
        gl.uniform3fv(places.missing, scene.missing);
        gl.uniform1i(places.samples, samples);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    // Numbers that a program writes, by their bits: integers can be drawn to everywhere.
    numbers(made, view, [columns, rows], targets, prepare) {
        const { gl } = this;
        const frame = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
        const buffers = [];
        for (let k = 0; k < targets; k++) {
            const buffer = gl.createRenderbuffer();
            gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
            gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32UI, columns, rows);
            gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.RENDERBUFFER, buffer);
            buffers.push(buffer);
        }
        gl.drawBuffers(buffers.map((_, k) => gl.COLOR_ATTACHMENT0 + k));
        gl.useProgram(made.program);
        this.aim(made, view);
        prepare(made.places);
        gl.viewport(0, 0, columns, rows);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const found = buffers.map((_, k) => {
            const bits = new Uint32Array(4 * columns * rows);
            gl.readBuffer(gl.COLOR_ATTACHMENT0 + k);
            gl.readPixels(0, 0, columns, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, bits);
            return new Float32Array(bits.buffer);
        });
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        buffers.forEach((buffer) => gl.deleteRenderbuffer(buffer));
        gl.deleteFramebuffer(frame);
        return found;
    }

    // What a pixel of the canvas sees, counted from the lower left corner.
    pick(view, which, x, y) {
        const made = this.program(which, null, view.screen, "PICK");
        const [sight, own, apart] = this.numbers(made, view, [1, 1], 3, (places) => {
            this.gl.uniform2f(places.at, x, y);
        });
        const place = ([u, v, face]) => ({ u, v, face });
        return { direction: [...sight.slice(0, 3)], held: sight[3] > 0, density: own[3], own: place(own), apart: place(apart) };
    }

    // Where the marked directions lie on a screen: parts of the viewport from its upper left corner, or NaN.
    locate(view) {
        const { gl } = this;
        const made = this.program(0, null, view.screen, "LOCATE");
        const size = [POINTS, Math.ceil(this.marks / POINTS)];
        const [found] = this.numbers(made, view, size, 1, (places) => {
            gl.activeTexture(gl.TEXTURE0);
            gl.bindTexture(gl.TEXTURE_2D, this.points);
            gl.uniform1i(places.points, 0);
        });
        return found;
    }
}

// Cameras ----------------------------------------------------------------------------------------

// Ry(yaw) Rx(pitch), column by column: right, up, back.
function poseOf({ yaw, pitch }) {
    const [sy, cy, sp, cp] = [Math.sin(yaw * DEGREE), Math.cos(yaw * DEGREE), Math.sin(pitch * DEGREE), Math.cos(pitch * DEGREE)];
    return [cy, 0, -sy, sp * sy, cp, sp * cy, cp * sy, -sp, cp * cy];
}

const lensOf = (look) => (look.screen === "perspective" && look.fov > WIDEST_PERSPECTIVE ? "stereographic" : look.screen);

function viewOf(scene, look, screen, rect) {
    const { aspect, edge, turns } = scene.screens[screen];
    const [, , width, height] = rect;
    let scale;
    if (edge) {
        const half = Math.tan((Math.min(look.fov, FOV[1]) / turns) * DEGREE) / edge;
        scale = [half, (half * height) / width];
    } else {
        // The whole map, as large as it fits.
        const fit = Math.min(width / aspect, height);
        scale = [width / (fit * aspect) / look.zoom, height / fit / look.zoom];
    }
    return { screen, rect, scale, pose: poseOf(look) };
}

// Controls ---------------------------------------------------------------------------------------

function made(tag, attributes = {}, children = []) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (name === "text") element.textContent = value;
        else if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
        else if (value !== false) element.setAttribute(name, value === true ? "" : value);
    }
    element.append(...children);
    return element;
}

function choice(label, values, get, set) {
    const select = made("select", { "aria-label": label, onchange: () => set(select.value) },
        values.map(([value, text]) => made("option", { value, text })));
    return { element: made("label", {}, [made("span", { text: label }), select]), show: () => { select.value = get(); } };
}

function flag(label, key, get, set) {
    const box = made("input", { type: "checkbox", "aria-keyshortcuts": key, onchange: () => set(box.checked) });
    return { element: made("label", { title: `${label} (${key})` }, [box, made("span", { text: label })]), show: () => { box.checked = get(); } };
}

function slider(label, [low, high, step], get, set, shown) {
    const range = made("input", { type: "range", min: low, max: high, step, "aria-label": label, oninput: () => set(Number(range.value)) });
    const output = made("output");
    return {
        element: made("label", {}, [made("span", { text: label }), range, output]),
        show: () => { range.value = get(); output.textContent = shown(get()); range.setAttribute("aria-valuetext", shown(get())); },
    };
}

// The page ---------------------------------------------------------------------------------------

export function mount(root, scene) {
    const several = scene.images.length > 1;
    const look = { comparison: several ? "split" : "first", first: 0, second: several ? 1 : 0, split: 0.5, blinked: false, beside: "", zoom: 1, ...scene.look };
    const start = { ...look };
    const canvas = made("canvas", {
        tabindex: 0, role: "application", "aria-label": `${scene.title}: ${scene.images.map((i) => i.about).join("; ")}. Arrow keys turn, plus and minus zoom.`,
        "aria-describedby": "spheremap-keys",
    });
    const labels = made("div", { class: "labels", "aria-hidden": "true" });
    const drawn = Object.assign(made("div"), { innerHTML: '<svg class="lines" aria-hidden="true"></svg>' }).firstChild;
    const legend = made("div", { class: "legend", role: "img" });
    const message = made("p", { class: "message", role: "alert", hidden: true });
    const readout = made("output", { class: "readout", "aria-live": "off", "aria-label": "Under the pointer" });
    const said = made("p", { class: "said", "aria-live": "polite" });
    const stage = made("div", { class: "stage" }, [canvas, drawn, labels, legend, message]);
    const change = (changes) => { set(changes); };
    const names = Object.keys(scene.screens);
    const controls = [
        choice("Screen", names.map((n) => [n, scene.screens[n].title ?? n]), () => look.screen, (screen) => change({ screen, zoom: 1 })),
        choice("Beside", [["", "nothing"], ...names.filter((n) => !scene.screens[n].edge).map((n) => [n, scene.screens[n].title ?? n])], () => look.beside, (beside) => change({ beside })),
        slider("Exposure", [-16, 16, 0.25], () => look.exposure, (exposure) => change({ exposure }), (x) => `${x > 0 ? "+" : ""}${x} stops`),
        choice("Curve", scene.curves.map((n) => [n, n]), () => look.curve, (curve) => change({ curve })),
        flag("False color", "f", () => look.false_color, (false_color) => change({ false_color })),
        flag("Isolines", "i", () => look.isolines, (isolines) => change({ isolines })),
        flag("Clipping", "c", () => look.clipping, (clipping) => change({ clipping })),
        flag("Graticule", "g", () => look.graticule > 0, (on) => change({ graticule: on ? start.graticule || 30 : 0 })),
        flag("Axes", "a", () => look.axes, (axes) => change({ axes })),
        flag("Not held", "v", () => look.valid, (valid) => change({ valid })),
        flag("Density", "d", () => look.density, (density) => change({ density })),
        flag("Tissot", "t", () => look.tissot, (tissot) => change({ tissot })),
        flag("Seams", "s", () => look.seams, (seams) => change({ seams })),
    ];
    if (several) {
        const images = scene.images.map((image, k) => [String(k), image.name]);
        controls.push(
            choice("Image", images, () => String(look.first), (k) => change({ first: Number(k) })),
            choice("Compared with", images, () => String(look.second), (k) => change({ second: Number(k) })),
            choice("How", COMPARISONS.map((n) => [n, n]), () => look.comparison, (comparison) => change({ comparison })),
            slider("Split", [0, 1, 0.01], () => look.split, (split) => change({ split }), (x) => `${Math.round(100 * x)} %`),
        );
    }
    const help = made("details", {}, [made("summary", { text: "Keys" }),
        made("dl", { id: "spheremap-keys" }, KEYS.flatMap(([key, what]) => [made("dt", { text: key }), made("dd", { text: what })]))]);
    const bar = made("div", { class: "bar", role: "toolbar", "aria-label": "View" }, [...controls.map((c) => c.element), help]);
    root.classList.add("spheremap");
    root.replaceChildren(stage, readout, bar, said);

    let shownSettings = "", painter = null, wanted = 0, quiet = 0, shrink = 1;
    const listeners = [], picked = [], resized = [];
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;

    // The viewports, the flat map to the right of the sphere.
    function views() {
        const { width, height } = canvas;
        if (!look.beside) return [viewOf(scene, look, lensOf(look), [0, 0, width, height])];
        const half = Math.floor(width / 2);
        return [viewOf(scene, look, lensOf(look), [0, 0, half, height]),
            viewOf(scene, { ...look, zoom: 1 }, look.beside, [half, 0, width - half, height])];
    }

    function fitted(ratio) {
        const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
        if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    }

    function draw(samples = 3) {
        if (!painter) return;
        for (const view of views()) painter.picture(view, look, samples);
        drawLabels();
    }

    // What is placed on the sphere, in the order of their directions.
    const placedOn = () => {
        const names = Object.entries(AXES).map(([text, of]) => ({ text, direction: homeOf(of) }));
        return { names, points: [...names, ...scene.marks, ...scene.lights].map((one) => one.direction).concat(...scene.lines.map((line) => line.points)) };
    };

    function drawLabels() {
        labels.replaceChildren();
        drawn.replaceChildren();
        const { names } = placedOn();
        const named = [...names, ...scene.marks], first = look.axes ? 0 : names.length;
        if (!look.axes && painter.marks === names.length) return;
        const part = (x) => x >= 0 && x <= 1;
        for (const view of views()) {
            const found = painter.locate(view);
            const [left, , width] = view.rect.map((side) => (100 * side) / canvas.width);
            const stand = (text, k, style = "", kind = "") => {
                const x = found[4 * k], y = found[4 * k + 1];
                if (!part(x) || !part(y)) return;
                labels.append(made("span", { text, class: kind, style: `left:${left + x * width}%;top:${100 * y}%;${style}` }));
            };
            scene.lights.forEach(({ size, color, sun }, k) => {
                const across = sun ? 26 : Math.max(5, 20 * size);
                stand("", named.length + k, `width:${across}px;height:${across}px;${sun ? "" : `background:${color}`}`, sun ? "sun" : "light");
            });
            for (let k = first; k < named.length; k++) stand(named[k].text, k);
            let k = named.length + scene.lights.length;
            for (const { text, points } of scene.lines) {
                drawLine(found.subarray(4 * k, 4 * (k + points.length)), view, text);
                k += points.length;
            }
        }
    }

    // A line of places, in pieces: none over a seam of the screen. Its name stands where it starts.
    function drawLine(found, view, text) {
        const [left, , width] = view.rect.map((side) => (side / canvas.width) * canvas.clientWidth), height = canvas.clientHeight;
        let path = "", before = null, start = null;
        for (let k = 0; k < found.length; k += 4) {
            const here = [found[k], found[k + 1]];
            // Far outside the picture a line is none.
            if (!(Math.max(...here.map((x) => Math.abs(x - 0.5))) < 8)) { before = null; continue; }
            const jumps = before && Math.max(...here.map((x, i) => Math.abs(x - before[i]))) > 0.25;
            const [x, y] = [left + here[0] * width, here[1] * height].map((p) => p.toFixed(1));
            path += `${before && !jumps ? "L" : "M"}${x} ${y}`;
            if (!start && here.every((p) => p >= 0 && p <= 1)) start = [x, y];
            before = here;
        }
        if (!path) return;
        for (const kind of ["halo", "stroke"]) {
            const element = document.createElementNS(drawn.namespaceURI, "path");
            element.setAttribute("d", path);
            element.setAttribute("class", kind);
            drawn.append(element);
        }
        if (text && start) labels.append(made("span", { text, class: "name", style: `left:${start[0]}px;top:${start[1]}px` }));
    }

    // From the first image's world, which a person reads, to the page's, and back.
    const homeOf = (d) => [0, 1, 2].map((i) => [0, 1, 2].reduce((sum, j) => sum + scene.world[j][i] * d[j], 0));
    const worldOf = (d) => [0, 1, 2].map((i) => [0, 1, 2].reduce((sum, j) => sum + scene.world[i][j] * d[j], 0));

    function drawLegend() {
        const on = look.density || (look.false_color && look.comparison !== "signed");
        legend.hidden = !on;
        if (!on) return;
        const ends = [8, 4, 0, -4, -8];
        const words = look.density ? ends.map((s) => `× ${s < 0 ? `1/${2 ** (-s / 2)}` : 2 ** (s / 2)}`)
            : ends.map((s) => `${s > 0 ? "+" : ""}${s}: ${tail(2 ** (s - look.exposure)).replace(/\.0+$/, "")}`);
        const colors = scene.ramp.map((c) => `rgb(${c.map((x) => Math.round(255 * x)).join(" ")})`);
        legend.setAttribute("aria-label", look.density ? "Colors of the solid angle of a texel, in means" : "Colors of luminance, in stops of 1 at this exposure");
        legend.replaceChildren(made("div", { class: "ramp", style: `background:linear-gradient(to top, ${colors.join(", ")})` }),
            made("ol", {}, words.map((text) => made("li", { text }))));
    }

    // Controls, when what they show has changed: a browser lays a page out anew for each.
    function show() {
        const settings = JSON.stringify({ ...look, yaw: 0, pitch: 0, fov: 0 });
        if (settings === shownSettings) return;
        shownSettings = settings;
        controls.forEach((control) => control.show());
        drawLegend();
    }

    // While a person moves, fewer pixels where frames take long; then all of them.
    function ask(moving = false) {
        if (!wanted) wanted = requestAnimationFrame((now) => frame(now, moving));
        clearTimeout(quiet);
    }

    function frame(now, moving) {
        wanted = 0;
        if (!painter) return;
        // In steps: a canvas of another size is another buffer.
        const part = moving ? 2 ** (Math.round(4 * Math.log2(shrink)) / 4) : 1;
        fitted(part * Math.min(devicePixelRatio, 2));
        draw(moving ? 1 : 3);
        clearTimeout(quiet);
        if (moving) {
            requestAnimationFrame((next) => learn(next - now));
            // Longer than a slow frame takes.
            quiet = setTimeout(() => ask(false), 400);
        } else quiet = setTimeout(prepare, 50);
    }

    // Milliseconds that a frame took: 25 a second are aimed at.
    function learn(took) {
        const factor = took > 45 ? Math.max(Math.sqrt(40 / took), 0.75) : took < 30 ? 1.1 : 1;
        shrink = clamp(shrink * factor, 0.25, 1);
    }

    // What the first move draws by, which would wait for its compiler.
    function prepare() {
        if (painter) views().forEach((view) => painter.drawing(view, look, true));
    }

    function set(changes, moving = false) {
        Object.assign(look, changes);
        look.fov = clamp(look.fov, ...FOV);
        look.pitch = clamp(look.pitch, -90, 90);
        look.yaw = ((look.yaw % 360) + 540) % 360 - 180;
        look.zoom = clamp(look.zoom, 1, 64);
        show();
        ask(moving);
        listeners.forEach((listener) => listener(look));
    }

    // What lies under a place on the canvas, in CSS pixels from its upper left corner.
    function pick(left, top) {
        if (!painter) return null;
        const x = (left / canvas.clientWidth) * canvas.width, y = canvas.height - (top / canvas.clientHeight) * canvas.height;
        const view = views().findLast((v) => x >= v.rect[0]);
        const part = (x - view.rect[0]) / view.rect[2];
        const other = several && (look.comparison === "second" || (look.comparison === "split" && part >= look.split) || (look.comparison === "blink" && look.blinked));
        const which = other ? look.second : look.first, image = scene.images[which];
        const { direction, held, density, own, apart } = painter.pick(view, which, x, y);
        const result = { which, image: image.name, direction: held ? worldOf(direction) : null };
        if (!held || Number.isNaN(own.u)) return result;
        const [faces, height, width] = image.shape;
        const nearest = (part, texels, corners) => clamp(Math.floor(corners ? part * (texels - 1) + 0.5 : part * texels), 0, texels - 1);
        const texel = [nearest(own.u, width, image.grid === "corners"), nearest(own.v, height, image.grid !== "centers")];
        if (faces > 1) result.face = Math.round(own.face);
        return { ...result, uv: [own.u, own.v], texel, solid_angle: density / (width * height), value: valueAt(which, apart) };
    }

    // Of the texel that was sent, which stands with its face apart.
    function valueAt(which, { u, v, face }) {
        const { place, width, height, gain } = scene.images[which];
        const column = clamp(Math.floor(u * place[0] + place[2] + 0.5), 1, width - 2);
        const row = clamp(Math.floor(v * place[1] + place[3] + 0.5), 1, height - 2);
        const k = 4 * ((Math.round(face) * height + row) * width + column);
        const texel = painter.texels[which].subarray(k, k + 4);
        if (texel[3] === 0) return null;
        return texel[3] === 0x3c00 ? [...texel.subarray(0, 3)].map((half) => halfToNumber(half) * gain) : [NaN, NaN, NaN];
    }

    function tell(left, top, clicked = false) {
        const found = pick(left, top);
        if (found) picked.forEach((listener) => listener(found, clicked));
        read(found);
    }

    function read(found) {
        if (!found || !found.direction) { readout.textContent = "no direction"; return; }
        const parts = [`direction ${found.direction.map((x) => x.toFixed(4)).join(" ")}`];
        if (found.uv) {
            parts.push(`uv ${found.uv.map((x) => x.toFixed(5)).join(" ")}`,
                `texel ${found.texel.join(", ")}${"face" in found ? `, face ${found.face}` : ""}`,
                `value ${found.value ? found.value.map((x) => (x === null ? "not finite" : tail(x))).join(" ") : "none"}`, `${tail(found.solid_angle)} sr`);
        } else parts.push("not in the image");
        if (several) parts.unshift(found.image);
        readout.textContent = parts.join(" · ");
    }

    // Hands ---------------------------------------------------------------------------------------

    const pointers = new Map();
    const perPixel = () => (scene.screens[lensOf(look)].edge ? look.fov : 360 / look.zoom) / canvas.clientWidth;
    const closer = (factor) => (scene.screens[lensOf(look)].edge ? { fov: look.fov * factor } : { zoom: look.zoom / factor });
    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    });
    canvas.addEventListener("pointermove", (event) => {
        const before = pointers.get(event.pointerId), here = [event.offsetX, event.offsetY];
        if (!before) { tell(...here); return; }
        const others = [...pointers].filter(([id]) => id !== event.pointerId);
        pointers.set(event.pointerId, here);
        if (others.length) {
            const [, other] = others[0];
            const apart = ([x, y]) => Math.max(Math.hypot(x - other[0], y - other[1]), 1);
            set(closer(apart(before) / apart(here)), true);
        } else {
            const each = perPixel();
            set({ yaw: look.yaw + (here[0] - before[0]) * each, pitch: look.pitch + (here[1] - before[1]) * each }, true);
        }
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    let pressed = [0, 0];
    canvas.addEventListener("pointerdown", (event) => { pressed = [event.offsetX, event.offsetY]; });
    // A click is what ends where it began.
    canvas.addEventListener("click", (event) => {
        if (Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) < 3) tell(event.offsetX, event.offsetY, true);
    });
    canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        set(closer(2 ** (clamp(event.deltaY, -120, 120) / 480)), true);
    }, { passive: false });

    const toggle = (name, label) => () => { set({ [name]: !look[name] }); said.textContent = `${label} ${look[name] ? "on" : "off"}`; };
    const turn = (yaw, pitch) => (event) => {
        const step = (event.shiftKey ? 15 : 3) * Math.min(1, look.fov / 60);
        set({ yaw: look.yaw + yaw * step, pitch: look.pitch + pitch * step }, true);
        said.textContent = `direction ${directionOf().map((x) => x.toFixed(2)).join(" ")}`;
    };
    const directionOf = () => worldOf(poseOf(look).slice(6).map((x) => -x));
    const zoom = (factor) => () => { set(closer(factor), true); said.textContent = `field of view ${look.fov.toFixed(0)} degrees`; };
    const expose = (stops) => () => { set({ exposure: clamp(look.exposure + stops, -16, 16) }); said.textContent = `exposure ${look.exposure} stops`; };
    const actions = {
        ArrowLeft: turn(1, 0), ArrowRight: turn(-1, 0), ArrowUp: turn(0, 1), ArrowDown: turn(0, -1),
        "+": zoom(0.9), "=": zoom(0.9), "-": zoom(1 / 0.9), "[": expose(-0.5), "]": expose(0.5),
        Home: () => { set({ yaw: start.yaw, pitch: start.pitch, fov: start.fov, zoom: 1 }); said.textContent = "first view"; },
        f: toggle("false_color", "false color"), i: toggle("isolines", "isolines"), c: toggle("clipping", "clipping"), a: toggle("axes", "axes"),
        v: toggle("valid", "what is not held"), d: toggle("density", "density"), t: toggle("tissot", "Tissot's circles"), s: toggle("seams", "seams"),
        g: () => { set({ graticule: look.graticule ? 0 : start.graticule || 30 }); said.textContent = `graticule ${look.graticule ? "on" : "off"}`; },
        p: () => { set({ screen: names[(names.indexOf(look.screen) + 1) % names.length], zoom: 1 }); said.textContent = look.screen; },
        b: () => { set({ beside: look.beside ? "" : "latlong" }); },
        x: () => {
            if (!several) return;
            if (look.comparison === "blink") set({ blinked: !look.blinked });
            else set({ first: look.second, second: look.first });
            said.textContent = scene.images[look.first].name;
        },
    };
    canvas.addEventListener("keydown", (event) => {
        const action = !event.ctrlKey && !event.metaKey && !event.altKey && actions[event.key];
        if (!action) return;
        event.preventDefault();
        action(event);
    });
    const blinking = several && !still && setInterval(() => { if (look.comparison === "blink") set({ blinked: !look.blinked }); }, 700);
    const sized = new ResizeObserver(() => { ask(); resized.forEach((listener) => listener()); });
    sized.observe(canvas);

    const fail = (error) => { message.textContent = error.message; message.hidden = false; throw error; };
    const ready = (async () => {
        const made = new Painter(canvas, scene);
        canvas.addEventListener("webglcontextlost", () => { if (gone) return; message.textContent = "The graphics card was lost: reload."; message.hidden = false; });
        await made.load();
        made.mark(placedOn().points);
        painter = made;
        show();
        fitted(Math.min(devicePixelRatio, 2));
        draw();
        quiet = setTimeout(prepare, 50);
    })().catch(fail);
    // The camera that looks along a direction of the reader's world.
    function aim(direction) {
        const [x, y, z] = homeOf(direction), level = Math.hypot(x, z);
        set({ yaw: level > 1e-12 ? Math.atan2(-x, -z) / DEGREE : 0, pitch: Math.atan2(y, level) / DEGREE });
    }
    // Other images, looked at in the same way. Of several that are on their way only the last comes.
    let asked = 0, gone = false;
    async function swap(next) {
        const turn = ++asked;
        await ready;
        const texels = await Promise.all(next.images.map(textureWords));
        if (turn !== asked || gone) return;
        Object.assign(scene, next);
        painter.store(texels);
        painter.mark(placedOn().points);
        ask();
    }
    // What the page shows now, of whole images.
    const seen = () => {
        const [{ screen, rect }] = views(), { yaw, pitch, fov, zoom } = look;
        return { yaw, pitch, fov, zoom, screen, size: [rect[3], rect[2]],
            images: several && look.comparison !== "first" ? [look.first, look.second] : [look.first] };
    };
    const sharpen = (which, record, words) => { painter?.sharpen(which, record, words); ask(); };
    function dispose() {
        gone = true;
        clearInterval(blinking);
        clearTimeout(quiet);
        sized.disconnect();
        painter?.drop();
        painter = null;
    }
    return { look, set, aim, pick, draw, ready, canvas, swap, sharpen, read, dispose, seen, direction: directionOf,
        onlook: (listener) => listeners.push(listener), onpick: (listener) => picked.push(listener), onsize: (listener) => resized.push(listener) };
}

// A widget of anywidget: traits of the model are settings of the page, both ways.
const SHARED = ["fov", "exposure", "curve", "false_color", "isolines", "clipping", "graticule", "axes", "valid", "density", "tissot", "seams"];

function render({ model, el }) {
    const root = made("div", { style: "height:520px" });
    el.append(root);
    const view = mount(root, structuredClone(model.get("scene")));
    let waiting = 0, busy = false;
    // Each side tells the other of changes, and not of those that it was told of.
    const alone = (work) => (...given) => {
        if (busy) return;
        busy = true;
        try { work(...given); } finally { busy = false; }
    };
    // What a hand does is told a few times a second.
    const save = () => { waiting ||= setTimeout(() => { waiting = 0; model.save_changes(); }, 100); };
    const changed = alone(() => {
        view.set(Object.fromEntries(SHARED.map((name) => [name, model.get(name)])));
        const asked = model.get("direction"), here = view.direction();
        if (Math.hypot(...asked.map((x, k) => x - here[k])) > 1e-9) view.aim(asked);
    });
    view.onlook(alone(() => {
        SHARED.forEach((name) => model.set(name, view.look[name]));
        model.set("direction", view.direction());
        save();
    }));
    // Values are asked of the array itself, one question at a time.
    let question = null, answering = 0;
    const inquire = () => {
        if (answering || !question) return;
        model.send({ kind: "pick", ...question });
        question = null;
        answering = setTimeout(() => { answering = 0; inquire(); }, 60);
    };
    view.onpick(({ which, direction }, clicked) => {
        if (!direction) return;
        if (clicked) model.send({ kind: "pick", image: which, direction, clicked: true });
        else { question = { image: which, direction }; inquire(); }
    });
    const answered = () => view.read(model.get("picked"));
    // And pictures of what is seen, when it has come to rest and the last one has come.
    let resting = 0, waited = false, seen = "";
    const look = () => {
        const asked = view.seen(), key = JSON.stringify(asked);
        if (waited || key === seen || !view.canvas.isConnected) return;
        const sent = model.get("scene").images;
        asked.images = asked.images.filter((k) => sent[k].reduced);
        if (!asked.images.length) return;
        [waited, seen] = [true, key];
        model.send({ kind: "see", ...asked });
    };
    const rest = () => { clearTimeout(resting); resting = setTimeout(look, 200); };
    view.onlook(rest);
    view.onsize(rest);
    const heard = (said, buffers) => {
        if (said.kind === "seen") { waited = false; rest(); }
        if (said.kind !== "detail") return;
        const [{ buffer, byteOffset, byteLength }] = buffers;
        view.sharpen(said.image, said, new Uint16Array(buffer.slice(byteOffset, byteOffset + byteLength)));
    };
    const swapped = async () => { await view.swap(structuredClone(model.get("scene"))); seen = ""; rest(); };
    const handlers = [["msg:custom", heard], ["change:picked", answered], ["change:scene", swapped],
        ...[...SHARED, "direction"].map((name) => [`change:${name}`, changed])];
    handlers.forEach(([name, handler]) => model.on(name, handler));
    changed();
    view.ready.then(rest);
    return () => { handlers.forEach(([name, handler]) => model.off(name, handler)); view.dispose(); };
}

export default { render };
