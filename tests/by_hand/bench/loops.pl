#!/usr/bin/perl
# usage: loops.pl VORONOID OUTDIR: the border loops that inspect finds of clouds whose holes are known. Writes OUTDIR/loops.md.
use strict;
use warnings;
use utf8;
use lib 'tests/by_hand/bench';
use Bench;
use JSON::PP;

my $out = begin('Loops');
my $tools = yardstick() =~ s{[^/]+$}{}r;
my $holes = 40;
my @rows = (
    { name => 'loops_igea_holes10', input => 'igea_holes10', wide => 10, asked => ['found >= 39', 'false <= 0'] },
    { name => 'loops_igea_holes5', input => 'igea_holes5', wide => 5, asked => ['found >= 38', 'false <= 0'] },
    { name => 'loops_igea30k', input => 'igea30k', true => 0, asked => ['false <= 0'] },
    { name => 'loops_cow20k', input => 'cow20k', true => 0, asked => ['false <= 0'] },
    { name => 'loops_fandisk30k_noise2', input => 'fandisk30k_noise2', true => 0, asked => ['false <= 0'] },
    { name => 'loops_shell60k', input => 'shell60k', true => 0, asked => ['false <= 0'] },
    { name => 'loops_arma2_120k', input => 'arma2_120k', true => 0, asked => ['false <= 0'] },
    { name => 'loops_armadillo_half', input => 'armadillo_half', true => 4 },
    { name => 'loops_bunny', public => 'bunny', true => 5 },
    { name => 'loops_office1', public => 'office1' },
);

# igea, 60,000 points, with holes around points far from each other, so many spacings wide. Their middles stand beside the
# cloud, and the spacing before them.
sub punched {
    my ($row) = @_;
    my $path = made($row->{input});
    return if -e $path || !-r "${tools}makeclouds.py";
    my $script = <<"END";
import sys; sys.path.insert(0, '$tools')
from cloudio import *
from makeclouds import mesh
v, f = mesh('igea_mesh.ply')
p = sample_mesh(v, f, 60_000, 21)[0]
t = v[f]
spacing = np.sqrt(np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1).sum() / 2 / len(p))
chosen = [0]
far = np.linalg.norm(p - p[0], axis=1)
while len(chosen) < $holes:
    chosen.append(int(far.argmax()))
    far = np.minimum(far, np.linalg.norm(p - p[chosen[-1]], axis=1))
keep = np.ones(len(p), bool)
for c in chosen:
    keep &= np.linalg.norm(p - p[c], axis=1) >= $row->{wide} / 2 * spacing
write_ply('$path', p[keep])
with open('$path.holes', 'w') as h:
    h.write('%.9g\\n' % spacing + ''.join('%.9g %.9g %.9g\\n' % tuple(p[c]) for c in chosen))
END
    system('/usr/bin/python3', '-c', $script) == 0 or die "no $path\n";
    return;
}

# How many of the holes have a loop around them: its centre lies within a third of their width of theirs.
sub found {
    my ($path, $wide, @loops) = @_;
    open my $in, '<', "$path.holes" or return;
    my ($spacing, @middles) = map { [split] } <$in>;
    my $found = 0;
    for my $m (@middles) {
        my @near = grep {
            my $c = $_->{centre};
            ($c->{x} - $m->[0])**2 + ($c->{y} - $m->[1])**2 + ($c->{z} - $m->[2])**2 < ($wide / 3 * $spacing->[0])**2;
        } @loops;
        $found++ if @near;
    }
    return $found;
}

my @table;
for my $row (grep { wanted($_->{name}) } @rows) {
    my $path = $row->{public} ? public($row->{public}) : made($row->{input});
    punched($row) if $row->{wide};
    if (my $absent = missing($row->{name}, $path)) {
        push @table, $absent;
        next;
    }
    my $run = timed($ARGV[0], 'inspect', $path, '--json', '--threads', 1);
    my $told = decode_json(join '', @{ $run->{lines} });
    my $border = $told->{border};
    my %figures = (found => $row->{wide} ? found($path, $row->{wide}, @{ $told->{loops} }) : undef);
    $figures{false} = $border->{loops} - ($row->{true} // $figures{found}) if defined $row->{true} || $row->{wide};
    push @table, [
        $row->{name}, $told->{points}{all}, $border->{loops}, $border->{holes}, $row->{wide} ? $holes : $row->{true} // '-',
        number($figures{found}), number($figures{false}), $border->{open}, spread('cpu', $run), judge(\%figures, @{ $row->{asked} // [] }),
    ];
}
exit 0 unless @table;
table(['case', 'n', 'loops', 'holes', 'true', 'found', 'false', 'rows left open', 'cpu s', 'asked'], \@table,
    'igea with 40 holes of 10 and of 5 spacings (square root of area / n): found if the centre of a loop lies within a third of its '
    . 'width of its middle. The others are closed, but for the cut of half an armadillo, bunny\'s base, and a depth scan of a room.');
finish('loops');
