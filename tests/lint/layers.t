#!/usr/bin/perl
# The include law of ARCHITECTURE.md, read off the #include lines.
use strict;
use warnings;
use Test::More;

# Room of a file, lowest number lowest: a file may include its own room and lower ones.
my %core = (base => 0, knn => 1, geom => 2, opt => 3, method => 4, metrics => 3, mesh => 3, align => 3);
my %door = (
    'microhttpd.h'  => qr{^server/http(?:_\w+)?\.[ch]$},
    'cjson/cJSON.h' => qr{^proto/json\.c$},
    'cJSON.h'       => qr{^proto/json\.c$},
    'flann/flann.h' => qr{^core/knn/knn_flann\.c$},
    'sqlite3.h'     => qr{^server/store_sqlite\.c$},
    'curl/curl.h'   => qr{^server/cli/remote\.c$},
);

sub core_room {
    my ($path) = @_;
    return $path =~ m{^core/(\w+)/} ? $1 : '';
}

# What is wrong with one include, or nothing.
sub fault {
    my ($from, $to) = @_;
    if ($to =~ m{^(core|proto|server)/}) {
        my %rank = (core => 0, proto => 1, server => 2);
        my ($a) = $from =~ m{^(\w+)/};
        my ($b) = $to =~ m{^(\w+)/};
        return "$a sees $b" if $rank{$b} > $rank{$a};
        return "$a sees the inside of core"
            if $b eq 'core' && $a ne 'core' && $to !~ m{^core/(?:base/\w+|spec|engine)\.h$};
        if ($a eq 'core' && $b eq 'core') {
            my ($x, $y) = (core_room($from), core_room($to));
            return '' if $x eq '' || $x eq $y;
            if ($y eq '') {
                return $to eq 'core/spec.h' || ($to eq 'core/engine.h' && $x eq 'method') ? '' : "$x sees $to";
            }
            return "$x is not a room" unless exists $core{$x};
            return "$y is not a room" unless exists $core{$y};
            return '' if $x eq 'method';
            return "$x sees $y" if $core{$y} >= $core{$x};
        }
        return '';
    }
    return "$to has its one door elsewhere" if exists $door{$to} && $from !~ $door{$to};
    return "$to has its one door elsewhere" if $to =~ m{^draco/} && $from ne 'proto/draco_shim.cc';
    return "$to has its one door elsewhere" if $to =~ m{^nettle/} && $from ne 'server/digest.c';
    return "$to has its one door elsewhere" if $to =~ m{^libpq} && $from ne 'server/store_postgres.c';
    return '';
}

my @files = split /\n/, `git ls-files -co --exclude-standard core proto server`;
@files = grep { /\.(?:[ch]|cc)$/ } @files;
cmp_ok(scalar @files, '>', 20, 'there are sources to look at');

my @faults;
for my $file (@files) {
    open my $in, '<', $file or next;
    while (my $line = <$in>) {
        next unless $line =~ /^\s*#\s*include\s*([<"])([^>"]+)[>"]/;
        my ($quote, $to) = ($1, $2);
        my $why = fault($file, $to);
        $why = 'not written from the root' if !$why && $quote eq '"' && !-f $to;
        push @faults, "$file:$.: $to: $why" if $why;
    }
    close $in;
}
is(join("\n", @faults), '', 'every include keeps the law');

is(fault('core/geom/cell.c', 'core/method/cvt.h'), 'geom sees method', 'a violation inside core is seen');
is(fault('proto/sse.c', 'server/http.h'), 'proto sees server', 'a violation between rooms is seen');
isnt(fault('server/queue.c', 'sqlite3.h'), '', 'a second door is seen');

my @cpp = grep { /\.cc$/ } @files;
is("@cpp", 'proto/draco_shim.cc', 'there is one C++ file');
done_testing();
