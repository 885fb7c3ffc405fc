// A search box that works from a folder, without a server: sections are in search-index.js, made by build.py.
(() => {
  const MOST = 12, AROUND = 60;
  const box = document.createElement('div'), field = document.createElement('input'), list = document.createElement('ol');
  box.className = 'lake-search';
  field.type = 'search';
  field.placeholder = 'Search';
  field.setAttribute('aria-label', 'Search the manual');
  list.setAttribute('aria-live', 'polite');
  box.append(field, list);
  document.querySelector('.md-header__inner').append(box);

  const lower = section => (section.lower ??= {title: section.title.toLowerCase(), text: section.text.toLowerCase()});
  const score = (section, words) => {
    const {title, text} = lower(section);
    if (!words.every(word => title.includes(word) || text.includes(word))) return 0;
    return words.reduce((sum, word) => sum + (title.includes(word) ? 10 : 0) + Math.min(text.split(word).length - 1, 5), 0);
  };
  const entry = (section, words) => {
    const item = document.createElement('li'), link = document.createElement('a'), text = document.createElement('small');
    link.href = `${section.page}#${section.anchor}`;
    link.textContent = section.title;
    const at = Math.max(...words.map(word => lower(section).text.indexOf(word)), 0);
    text.textContent = section.text.slice(Math.max(at - AROUND, 0), at + 2 * AROUND);
    item.append(link, text);
    return item;
  };
  field.addEventListener('input', () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(word => word.length > 1);
    const found = words.length === 0 ? [] : lakeSearchIndex.map(section => [score(section, words), section])
      .filter(([points]) => points > 0).sort(([a], [b]) => b - a).slice(0, MOST);
    list.replaceChildren(...found.map(([, section]) => entry(section, words)));
    if (words.length > 0 && found.length === 0) list.append(Object.assign(document.createElement('li'), {textContent: 'Nothing found'}));
  });
  field.addEventListener('keydown', event => {
    if (event.key === 'Escape') field.value = '', list.replaceChildren();
    if (event.key === 'Enter') list.querySelector('a')?.click();
  });
  list.addEventListener('click', () => list.replaceChildren());
})();
