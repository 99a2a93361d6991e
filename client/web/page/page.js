// The page: a gallery of the server's models, or one model (#name) that refines as its bytes arrive.

import { Gallery } from './gallery.js';
import { Viewer } from './viewer.js';

const at = (id) => document.getElementById(id);
const root = document.documentElement;

function setTheme(theme) {
  root.dataset.theme = theme;
  dispatchEvent(new Event('theme'));
}

setTheme(localStorage.getItem('theme') ?? (matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark'));
at('theme').addEventListener('click', () => {
  const theme = root.dataset.theme === 'dark' ? 'light' : 'dark';
  localStorage.setItem('theme', theme);
  setTheme(theme);
});

const gallery = new Gallery(at('gallery'));
const viewer = new Viewer(at('viewer'));

function route() {
  const name = decodeURIComponent(location.hash.slice(1));
  at('title').textContent = name;
  document.title = name ? `${name} – mvw` : 'mvw';
  at('viewer').hidden = !name;
  at('gallery').hidden = Boolean(name);
  if (name) {
    gallery.leave();
    viewer.open(name);
  } else {
    viewer.leave();
    gallery.enter();
  }
}

addEventListener('hashchange', route);
addEventListener('keydown', (event) => {
  if (event.key === 'Escape') location.hash = '';
});
route();
