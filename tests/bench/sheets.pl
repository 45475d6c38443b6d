#!/usr/bin/perl
# usage: sheets.pl VORONOID OUTDIR: shapes whose sheets cross, lie over each other or are thin. Writes OUTDIR/sheets.md.
use strict;
use warnings;
use utf8;
use lib 'tests/bench';
use Bench;
use JSON::PP;

my $out = begin('Sheets');
my @rows = (
    { name => 'sheets_vox120k', process => 'upsample', input => made('armadillo_vox120k'), truth => public('armadillo_mesh'), points => 480_000 },
    { name => 'sheets_arma2_120k', process => 'upsample', input => made('arma2_120k'), truth => made('arma2_mesh'), points => 480_000,
        asked => ['delta_sheet <= 0.12', 'off_surface_rms <= 3.8e-4', 'over_vox <= 2.5'],
        goal => ['delta_sheet <= 0.07', 'over_vox <= 1.5'] },
    { name => 'sheets_shell60k', process => 'upsample', input => made('shell60k'), truth => made('shell_mesh'), points => 240_000,
        asked => ['delta_sheet <= 0.08', 'hex_sheet >= 0.806', 'off_surface_mean <= 2.4e-4', 'cpu <= 15'],
        goal => ['delta_sheet <= 0.05', 'cpu <= 8'] },
    { name => 'sheets_cow20k', process => 'upsample', input => made('cow20k'), truth => public('cow_mesh'), points => 80_000,
        asked => ['delta <= 0.074', 'off_surface_rms <= 4.0e-4'], goal => ['delta <= 0.05', 'off_surface_rms <= 3e-4'] },
    { name => 'sheets_scannet', process => 'resample', input => public('scannet'), points => 10_000, asked => ['delta <= 0.046'],
        goal => ['delta <= 0.035'] },
);

# What the yardstick's sheets.py says: uniformity among the points of one sheet.
sub by_sheet {
    my ($result, $truth) = @_;
    my $sheets = yardstick() =~ s{[^/]+$}{sheets.py}r;
    open my $from, '-|', '/usr/bin/python3', $sheets, $result, '--mesh', $truth or die "python3: $!\n";
    my $measured = decode_json(join '', <$from>);
    close $from or die "$sheets $result: failed\n";
    return %$measured;
}

my (@table, $vox);
for my $row (grep { wanted($_->{name}) } @rows) {
    if (my $absent = missing($row->{name}, grep({ defined } @{$row}{qw(input truth)}), yardstick())) {
        push @table, $absent;
        next;
    }
    my $result = "$out/sheets.ply";
    my @arguments = ('--points', $row->{points}, '--threads', 1);
    my @runs = map { process($row->{process}, $row->{input}, $result, @arguments) } 1 .. runs();
    my %figures = (against($result, $row->{input}), $row->{truth} ? by_sheet($result, $row->{truth}) : ());
    unlink $result;
    $figures{cpu} = median(map { $_->{cpu} } @runs);
    $vox = $figures{cpu} if $row->{name} eq 'sheets_vox120k';
    $figures{over_vox} = $figures{cpu} / $vox if $vox;
    push @table, [
        "$row->{name} → $row->{points} $row->{process}",
        map({ number($figures{$_}) } qw(n delta delta_sheet hex_sheet measured too_near off_surface_mean off_surface_rms)),
        spread('cpu', @runs), sprintf('%.0f', $runs[0]{rss}), judge(\%figures, @{ $row->{asked} // [] }),
        judge(\%figures, @{ $row->{goal} // [] }),
    ];
}
exit 0 if !@table;
table([
    'case', qw(n delta delta_sheet hex_sheet measured too_near off_surface_mean off_surface_rms), 'cpu s', 'rss MB', 'asked', 'goal',
], \@table, 'delta_sheet, hex_sheet, too_near: among the points of one true sheet, because plain delta rewards merging two. over_vox: CPU '
    . 'over that of sheets_vox120k, whose sheets lie apart. cpu: the whole process, file to file, one thread.');
finish('sheets');
