/* The page: what happens in which order. */
import { readCloud } from './cloud.js';
import { $, bytes, count } from './dom.js';
import { wireDrop } from './drop.js';
import { setCloud, setLayout, wireStage } from './stage.js';
import { wireTheme } from './theme.js';

const stage = wireStage(() => {});
wireTheme($('theme'), stage);
wireDrop(async (file) => {
    $('trouble').textContent = '';
    const cloud = await readCloud(await file.arrayBuffer());
    $('cloud-words').textContent = `${file.name}: ${count(cloud.n)} points, ${bytes(file.size)}`;
    setCloud('input', cloud);
    setLayout('input');
});
