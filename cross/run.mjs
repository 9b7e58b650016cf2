// Prints the lines of the WebAssembly module: node run.mjs MODULE STEPS
import { readFileSync } from "node:fs";

const [path, steps] = process.argv.slice(2);
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(path)));
for (let index = 0; ; index++) {
  const found = BigInt.asUintN(64, exports.line(index, Number(steps)));
  if (found === 0n) break;
  const [start, length] = [Number(found >> 32n), Number(found & 0xffffffffn)];
  console.log(new TextDecoder().decode(new Uint8Array(exports.memory.buffer, start, length)));
}
