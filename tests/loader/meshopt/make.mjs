// Makes the files beside it:
//   npm install meshoptimizer@1.3.0 gltfpack@1.3.0 && node make.mjs SCENE.glb
// streams.json: what the format's author encodes, with what his decoder makes of it.
// packed-*.glb: a scene by gltfpack with codes of either extension; decoded.bin: what his decoder makes of both.
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import { MeshoptEncoder } from 'meshoptimizer/encoder';

await Promise.all([MeshoptDecoder.ready, MeshoptEncoder.ready]);
const here = dirname(fileURLToPath(import.meta.url));
let seed = 1;
const random = () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) >>> 8) / 0x1000000;
const bytes = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
const base64 = (array) => Buffer.from(array).toString('base64');

const streams = [];
function add(name, mode, source, count, stride, filter, versions = [0, 1]) {
	for (const version of mode === 'ATTRIBUTES' ? versions : [undefined]) {
		const codes = MeshoptEncoder.encodeGltfBuffer(bytes(source), count, stride, mode, version);
		const decoded = new Uint8Array(count * stride);
		MeshoptDecoder.decodeGltfBuffer(decoded, count, stride, codes, mode, filter);
		const says = version === undefined ? name : `${name}, version ${version}`;
		streams.push({ name: says, mode, filter, count, stride, codes: base64(codes), decoded: base64(decoded) });
	}
}

// Steps of all sizes, so that groups of all widths occur; lengths around those of groups and blocks.
for (const [count, stride] of [[1, 4], [15, 4], [16, 8], [17, 12], [255, 4], [256, 16], [257, 16], [130, 64], [33, 256]]) {
	const data = new Uint8Array(count * stride);
	for (let k = 0; k < stride; k++) {
		const step = [0, 1, 3, 9, 40, 255][k % 6];
		for (let i = 0, value = k * 7; i < count; i++) {
			value += Math.floor((random() - 0.5) * step * (1 + Math.floor(i / 32) % 3));
			data[i * stride + k] = value;
		}
	}
	add(`bytes ${count} of ${stride}`, 'ATTRIBUTES', data, count, stride, 'NONE');
}
const shorts = new Uint16Array(200 * 4).map((_, i) => 1000 * (i % 4) + 37 * Math.floor(i / 4) + random() * 300);
add('shorts', 'ATTRIBUTES', shorts, 200, 8, 'NONE');
const waves = new Float32Array(200 * 3).map((_, i) => Math.sin(i * 0.01) * 3 + (i % 3));
add('floats', 'ATTRIBUTES', waves, 200, 12, 'NONE');
add('zeros', 'ATTRIBUTES', new Float32Array(100), 100, 4, 'NONE');
add('noise', 'ATTRIBUTES', new Uint8Array(64 * 8).map(() => random() * 256), 64, 8, 'NONE');

// Words of which other bits change than the lowest: the encoder turns their differences.
for (const turn of [3, 6, 11]) {
	const words = new Uint32Array(96).map((_, i) => (((i * 0x9e3779b1) >>> 0) & (0xff << turn)) >>> 0);
	const codes = MeshoptEncoder.encodeVertexBufferLevel(bytes(words), 96, 4, 3, 1);
	const decoded = new Uint8Array(96 * 4);
	MeshoptDecoder.decodeGltfBuffer(decoded, 96, 4, codes, 'ATTRIBUTES', 'NONE');
	streams.push({ name: `turned ${turn}`, mode: 'ATTRIBUTES', filter: 'NONE', count: 96, stride: 4, codes: base64(codes), decoded: base64(decoded) });
}

const unit = (n) => {
	const v = Array.from({ length: n }, () => random() - 0.5);
	const length = Math.hypot(...v);
	return v.map((x) => x / length);
};
const many = 70;
const directions = new Float32Array(Array.from({ length: many }, () => [...unit(3), random() < 0.5 ? 1 : -1]).flat());
const turns = new Float32Array(Array.from({ length: many }, () => unit(4)).flat());
const wide = new Float32Array(many * 3).map(() => (random() - 0.5) * 10 ** Math.floor(random() * 12 - 6));
const colors = new Float32Array(many * 4).map(random);
for (const bits of [4, 8]) add(`octahedral ${bits}`, 'ATTRIBUTES', MeshoptEncoder.encodeFilterOct(directions, many, 4, bits), many, 4, 'OCTAHEDRAL');
for (const bits of [10, 16]) add(`octahedral ${bits}`, 'ATTRIBUTES', MeshoptEncoder.encodeFilterOct(directions, many, 8, bits), many, 8, 'OCTAHEDRAL');
for (const bits of [8, 12, 16]) add(`quaternion ${bits}`, 'ATTRIBUTES', MeshoptEncoder.encodeFilterQuat(turns, many, 8, bits), many, 8, 'QUATERNION');
for (const bits of [8, 15, 24]) for (const shared of ['Separate', 'SharedVector'])
	add(`exponential ${bits} ${shared}`, 'ATTRIBUTES', MeshoptEncoder.encodeFilterExp(wide, many, 12, bits, shared), many, 12, 'EXPONENTIAL', [1]);
for (const bits of [5, 8]) add(`color ${bits}`, 'ATTRIBUTES', MeshoptEncoder.encodeFilterColor(colors, many, 4, bits), many, 4, 'COLOR', [1]);
for (const bits of [12, 16]) add(`color ${bits}`, 'ATTRIBUTES', MeshoptEncoder.encodeFilterColor(colors, many, 8, bits), many, 8, 'COLOR', [1]);

// A lattice's triangles in good order, the same shuffled, and such that share nothing.
const n = 10;
const lattice = [];
for (let y = 0; y < n; y++) for (let x = 0; x < n; x++) {
	const at = y * (n + 1) + x;
	lattice.push([at, at + 1, at + n + 1], [at + 1, at + n + 2, at + n + 1]);
}
const ordered = new Uint32Array(lattice.flat());
MeshoptEncoder.reorderMesh(ordered, true, true);
const shuffled = [...lattice].sort(() => random() - 0.5).flat();
const apart = Array.from({ length: 80 }, () => [0, 0, 0].map(() => Math.floor(random() * 60000))).flat();
const restarts = [...ordered.slice(0, 60), ...ordered.slice(0, 60)];
for (const [name, list] of Object.entries({ ordered: [...ordered], shuffled, apart, restarts })) {
	const [short, long] = [new Uint16Array(list), new Uint32Array(list.map((index) => index + (name === 'apart' ? 70000 : 0)))];
	for (const mode of ['TRIANGLES', 'INDICES']) {
		add(`${name}, shorts`, mode, short, list.length, 2, 'NONE');
		add(`${name}, words`, mode, long, list.length, 4, 'NONE');
	}
}
writeFileSync(join(here, 'streams.json'), `[\n${streams.map((s) => JSON.stringify(s)).join(',\n')}\n]\n`);

const cli = join(dirname(fileURLToPath(import.meta.resolve('gltfpack/package.json'))), 'cli.js');
const decoded = ['ext', 'khr'].map((which) => {
	const out = join(here, `packed-${which}.glb`);
	const flags = ['-i', process.argv[2], '-o', out, '-kn', '-km', which === 'khr' ? '-cz' : '-cc', '-ce', which];
	execFileSync(process.execPath, [cli, ...flags], { stdio: 'inherit' });
	const glb = readFileSync(out);
	const length = glb.readUInt32LE(12);
	const { buffers, bufferViews } = JSON.parse(glb.subarray(20, 20 + length));
	const fallback = new Uint8Array(buffers[1].byteLength);
	for (const view of bufferViews.filter((view) => view.extensions)) {
		const { byteOffset = 0, byteLength, count, byteStride, mode, filter } = Object.values(view.extensions)[0];
		const codes = glb.subarray(28 + length + byteOffset, 28 + length + byteOffset + byteLength);
		const target = new Uint8Array(count * byteStride);
		MeshoptDecoder.decodeGltfBuffer(target, count, byteStride, codes, mode, filter);
		fallback.set(target, view.byteOffset);
	}
	return fallback;
});
if (Buffer.compare(...decoded)) throw new Error('the two hold different data');
writeFileSync(join(here, 'decoded.bin'), decoded[0]);
