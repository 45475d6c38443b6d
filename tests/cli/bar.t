#!/usr/bin/perl
# The bar: drawn on a terminal, which script(1) stands for, and nowhere else.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use Cli;
use Test::More;

plan skip_all => 'the bar is drawn on a terminal: script(1) makes none here'
    if system('script -qec true /dev/null >/dev/null 2>&1 </dev/null') != 0;

my $folder = scratch();
my $in = spew("$folder/in.ply", sphere(3000));
my $binary = $ENV{VORONOID} // 'build/release/voronoid';

sub seen {
    my ($columns, @options) = @_;
    my $command = "stty cols $columns; '$binary' resample $in -n 300 --iterations 40 -fo $folder/out.ply @options";
    return scalar `script -qec "$command" /dev/null </dev/null`;
}

my $text = seen(80);
my @drawn = $text =~ /\r\e\[K(iterate\s+\d+\/40 [^\r]*)/g;
cmp_ok scalar @drawn, '>=', 1, 'a bar is drawn';
like $drawn[0], qr{^iterate    0/40   \[-+\]   0 %  delta \d\.\d{4}  \d+ s left\z}, 'it begins empty';
is scalar(grep { length > 80 } @drawn), 0, 'it fits into the line';
like $text, qr/\r\e\[Kvoronoid: \S+out\.ply: 300 points, [^\n]*\n/, 'the summary takes its place';

@drawn = seen(40) =~ /\r\e\[K(iterate\s+\d+\/40 [^\r]*)/g;
cmp_ok scalar @drawn, '>=', 1, 'a bar is drawn in a narrow window';
is scalar(grep { length >= 40 } @drawn), 0, 'and fits into the line there';

unlike seen(80, '--quiet'), qr/\S/, '--quiet draws nothing' ;
unlike seen(80, '--json'), qr/\e/, '--json draws no bar';

my $asked = "printf '%s\\n' no yes | script -qec 'for _ in 1 2; do $binary resample $in -n 300 -qo $folder/out.ply; echo =\$?; done' /dev/null";
like scalar `$asked`, qr/exists\. Overwrite it\? \[y\/N\].*=2.*exists\. Overwrite it.*=0/s, 'a terminal is asked before a file is overwritten';
done_testing;
