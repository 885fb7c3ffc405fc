// A chapter that is gone to is opened; on paper all are.
const chapters = [...document.querySelectorAll('.folded > details')];
const open = () => {
  const target = location.hash && document.getElementById(location.hash.slice(1));
  const chapter = target && target.querySelector(':scope > details');
  if (!chapter) return;
  chapter.open = true;
  target.scrollIntoView();
};
addEventListener('hashchange', open);
document.querySelectorAll('nav a').forEach(link => link.addEventListener('click', () => setTimeout(open)));
addEventListener('beforeprint', () => chapters.forEach(chapter => { chapter.open = true; }));
open();
